"""Error dynamics of powers of error and rate alone: finite time without a surface."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.error_dynamics.implicit_reaching import ImplicitReaching
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, below, noise_within_limit, supposed, valve_faster
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, Reaching, role
from hydroservo.core.signals import VelocityError


class HomogeneousErrorDynamicsState(NamedTuple):
    """What is asked for at this sample."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the error")]


@role(ErrorDynamics)
class HomogeneousErrorDynamics(NamedTuple):
    """A double integrator in finite time, by powers of error and rate that scale alike.

    With every power odd (|x|^a sgn x)::

        q = k1 e^(a/(2-a)) + k2 (de/dt + s')^a

    with s' the shift by the observer's surfaces. The power of the rate is taken where it leads to, by the
    nested ``reaching``.

    Source: Bhat, Bernstein, IEEE Trans. Automatic Control 43(5), 1998, prop. 1 (unverified).
    Fails far from 0, where its powers pull less than a linear law, and where the error's rate is noisy.
    """

    error_gain: Annotated[float, Field("m^(1/3)/s^(7/3)", "gain k1 [(m/s)^(1-a/(2-a))/s^2]", above=0)]
    rate_gain: Annotated[float, Field("m^(1/5)/s^(7/5)", "gain k2 [(m/s^2)^(1-a)/s]", above=0)]
    exponent: Annotated[float, Field("", "exponent a", at_least=0.1, below=1)]
    reaching: Reaching = ImplicitReaching()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        noise = facts.model.g1() * facts.noise[1]
        size = self.error_gain * facts.demand.value
        return [
            noise_within_limit(self.rate_gain * noise**self.exponent, facts),
            below("range", "the error stays where powers pull more than a line", facts.demand, 1.0, "m/s"),
            valve_faster(self.error_gain**0.5, facts, "the root of k1"),
            *supposed(self.reaching, self.rate_gain, self.exponent, size, "m/s^2", facts.period),
        ]

    def init(self) -> HomogeneousErrorDynamicsState:
        return HomogeneousErrorDynamicsState(0.0, 0.0)

    def step(
        self, s: HomogeneousErrorDynamicsState, error: VelocityError, dt: float
    ) -> HomogeneousErrorDynamicsState:
        power = self.exponent / (2.0 - self.exponent)
        rate = error.rate + error.shift()
        return HomogeneousErrorDynamicsState(
            self.reaching.second(rate, 0.0, self.rate_gain, self.exponent, dt),
            self.error_gain * ops.signed_power(error.value, power),
        )
