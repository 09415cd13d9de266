"""Velocity from positions through Levant's robust exact differentiator."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import VelocityEstimator, role
from hydroservo.core.signals import Draws, MachineOutputs

LEVANT = "Levant, Automatica 34(3), 1998"


class ExactDifferentiatorState(NamedTuple):
    """The two states of the differentiator."""

    value: Annotated[float, Field("m/s", "estimated piston velocity")]
    position: Annotated[float, Field("m", "smoothed position")]


@role(VelocityEstimator)
class ExactDifferentiator(NamedTuple):
    """First-order robust exact differentiator (super-twisting), the sign solved for in each step.

    With y the measured position, eta = y_hat - y and L a bound of the acceleration::

        dy_hat/dt = v_hat - lambda_1 sqrt(L) sqrt|eta| sgn(eta)
        dv_hat/dt = -lambda_2 L sgn(eta)

    by backward Euler with xi in Sgn(eta): with b = y_hat + h v_hat - y, the new eta solves
    eta + h lambda_1 sqrt(L) sqrt|eta| sgn(eta) + h^2 lambda_2 L xi = b. If |b| <= h^2 lambda_2 L then eta = 0
    and xi = b/(h^2 lambda_2 L); otherwise xi = sgn(b) and sqrt|eta| is the positive root of a quadratic. Then
    y_hat = y + eta, and v_hat falls by h lambda_2 L xi. So sgn causes no chatter, and a ramp is met to
    rounding after a finite time; an acceleration within +-L shifts v_hat by at most h L/2. It starts at rest
    at the first position.

    Source: Levant, Automatica 34(3), 1998; backward Euler: Mojallizadeh, Brogliato, Acary, Int. J. Robust and
    Nonlinear Control 31(16), 2021.
    Fails to smooth anything where L is so large that the position's errors stay within h^2 lambda_2 L: v_hat
    is then the backward difference. Where the acceleration exceeds L, v_hat falls behind.
    """

    lipschitz: Annotated[float, Field("m/s^2", "bound L of the acceleration", above=0)]
    gain_1: Annotated[float, Field("", "gain lambda_1", LEVANT, above=0)] = 1.5
    gain_2: Annotated[float, Field("", "gain lambda_2; at least 1", LEVANT, at_least=1)] = 1.1

    def init(self) -> ExactDifferentiatorState:
        return ExactDifferentiatorState(0.0, math.nan)

    def step(
        self, s: ExactDifferentiatorState, machine: MachineOutputs, position: float, draws: Draws, dt: float
    ) -> ExactDifferentiatorState:
        lost = ops.isnan(s.position)  # at the start, and after a sample that was not a number
        velocity = ops.where(lost, 0.0 * position, s.value)  # nan where there is no position
        b = ops.where(lost, 0.0, s.position + dt * s.value - position)
        largest = dt * self.gain_2 * self.lipschitz
        reach = dt * largest
        linear = dt * self.gain_1 * ops.sqrt(self.lipschitz)
        excess = ops.maximum(ops.absolute(b) - reach, 0.0)
        root = 2.0 * excess / (linear + ops.sqrt(linear * linear + 4.0 * excess))
        error = ops.copysign(root * root, b)
        return ExactDifferentiatorState(velocity - largest * ops.clip(b / reach, -1.0, 1.0), position + error)
