"""Robust integral of the sign of the error."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import (
    Assumption,
    Facts,
    below,
    disturbance_slower,
    sampled_faster,
    valve_faster,
)
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, role
from hydroservo.core.signals import VelocityError


class RISEErrorDynamicsState(NamedTuple):
    """What is asked for at this sample, the surface, and the integral."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the surface")]
    sigma: Annotated[float, Field("m/s^2", "surface")]
    integral: Annotated[float, Field("m/s^3", "integral of the surface and its sign")]


@role(ErrorDynamics)
class RISEErrorDynamics(NamedTuple):
    """A surface and the integral of its sign: continuous, against disturbances with bounded rates.

    With sigma = de/dt + c e + s', s' the shift by the observer's surfaces::

        q = c de/dt + (k_s + 1) sigma + integral( (k_s + 1) alpha sigma + beta sgn(sigma) )

    Source: Xian, Dawson, de Queiroz, Chen, IEEE Trans. Automatic Control 49(7), 2004 (unverified).
    Fails where beta is below what the disturbance's rates ask for, and by a ripple of beta times the sample
    period, for sgn is taken at the sample.
    """

    surface_gain: Annotated[float, Field("1/s", "gain c of the error in the surface", above=0)]
    feedback_gain: Annotated[float, Field("1/s", "gain k_s + 1 of the surface", above=0)]
    integral_rate: Annotated[float, Field("1/s", "rate alpha of the surface in the integral", at_least=0)]
    sign_gain: Annotated[float, Field("m/s^4", "gain beta of the surface's sign", at_least=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        ripple = facts.period * self.sign_gain / (facts.model.g1() * facts.model.g2(0.0, 0.0))
        meaning = "beta h, as a command, is below a thousandth of its limit"
        fastest = max(self.surface_gain, self.feedback_gain)
        return [
            disturbance_slower("beta", self.sign_gain, facts),
            below("ripple", meaning, ripple, 1e-3 * facts.limit, "V"),
            sampled_faster(fastest, facts, "the larger of c and k_s + 1"),
            valve_faster(fastest, facts, "the larger of c and k_s + 1"),
        ]

    def init(self) -> RISEErrorDynamicsState:
        return RISEErrorDynamicsState(0.0, 0.0, 0.0, 0.0)

    def step(self, s: RISEErrorDynamicsState, error: VelocityError, dt: float) -> RISEErrorDynamicsState:
        sigma = error.rate + self.surface_gain * error.value + error.shift()
        linear = self.feedback_gain * sigma
        integral = s.integral + dt * (self.integral_rate * linear + self.sign_gain * ops.sign(sigma))
        return RISEErrorDynamicsState(self.surface_gain * error.rate, linear + integral, sigma, integral)
