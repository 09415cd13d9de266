"""A terminal sliding surface whose derivative has no negative power."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.error_dynamics.implicit_reaching import ImplicitReaching
from hydroservo.core import ops
from hydroservo.core.assumptions import (
    Assumption,
    Facts,
    noise_within_limit,
    sampled_faster,
    supposed,
    valve_faster,
)
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, Reaching, role
from hydroservo.core.signals import VelocityError


class NonsingularTerminalErrorDynamicsState(NamedTuple):
    """What is asked for at this sample, and the surface."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the surface")]
    sigma: Annotated[float, Field("m/s^2", "sliding surface")]


@role(ErrorDynamics)
class NonsingularTerminalErrorDynamics(NamedTuple):
    """One surface on which the error vanishes in finite time, without the singularity of a terminal one.

    With every power odd (|x|^a sgn x), 1 < p < 2, and s' the shift by the observer's surfaces::

        sigma = de/dt + (beta e)^(1/p) + s'
        q     = beta/p (de/dt)^(2-p) + k sigma + epsilon sigma^a

    On the surface an error e0 is gone after p/(p - 1) beta^(-1/p) |e0|^(1-1/p). Both powers in q are taken
    where they lead to, by the nested ``reaching``.

    Source: Feng, Yu, Man, Automatica 38(12), 2002, doi:10.1016/S0005-1098(02)00147-4 (unverified), with the
    surface solved for the error's rate.
    Fails where the error's rate is noisy: its power has an infinite slope at 0.
    """

    surface_gain: Annotated[float, Field("m^(2/7)/s^(18/7)", "beta [(m/s^2)^p s/m]", above=0)]
    linear_gain: Annotated[float, Field("1/s", "gain k", at_least=0)]
    power_gain: Annotated[float, Field("m^(4/9)/s^(17/9)", "gain epsilon [(m/s^2)^(1-a)/s]", at_least=0)]
    surface_exponent: Annotated[float, Field("", "exponent p", above=1, at_most=1.9)]
    exponent: Annotated[float, Field("", "exponent a", at_least=0.1, below=1)]
    reaching: Reaching = ImplicitReaching()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        p, noise = self.surface_exponent, facts.model.g1() * facts.noise[1]
        size = (self.surface_gain * facts.demand.value) ** (1.0 / p)
        return [
            noise_within_limit(self.surface_gain / p * noise ** (2.0 - p), facts),
            sampled_faster(self.linear_gain, facts, "k"),
            valve_faster(self.linear_gain, facts, "k"),
            *supposed(self.reaching, self.surface_gain / p, 2.0 - p, size, "m/s^2", facts.period),
        ]

    def init(self) -> NonsingularTerminalErrorDynamicsState:
        return NonsingularTerminalErrorDynamicsState(0.0, 0.0, 0.0)

    def step(
        self, s: NonsingularTerminalErrorDynamicsState, error: VelocityError, dt: float
    ) -> NonsingularTerminalErrorDynamicsState:
        p = self.surface_exponent
        sigma = error.rate + ops.signed_power(self.surface_gain * error.value, 1.0 / p) + error.shift()
        return NonsingularTerminalErrorDynamicsState(
            self.reaching.second(error.rate, 0.0, self.surface_gain / p, 2.0 - p, dt),
            self.reaching.second(sigma, self.linear_gain, self.power_gain, self.exponent, dt),
            sigma,
        )
