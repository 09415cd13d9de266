"""The super-twisting algorithm with a gain that follows how fast the disturbance changes."""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.error_dynamics.super_twisting import (
    SuperTwisting,
    SuperTwistingState,
    twisting_assumptions,
)
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import ErrorDynamics, role
from hydroservo.core.signals import VelocityError
from hydroservo.core.sources import CHOSEN


class AdaptiveSuperTwistingState(NamedTuple):
    """What SuperTwisting has as its state, and the bound with what it follows."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the surface")]
    sigma: Annotated[float, Field("m/s^2", "sliding surface")]
    learnt: Annotated[float, Field("m/s^3", "integral w of the surface's sign")]
    drive: Annotated[float, Field("m/s^3", "what the implicit step drives the surface with")]
    disturbance_rate: Annotated[float, Field("m/s^4", "bound L in force")]
    filtered: Annotated[float, Field("m/s^4", "rate of w, low-passed")]


@role(ErrorDynamics)
class AdaptiveSuperTwisting(NamedTuple):
    """:class:`SuperTwisting` whose bound L is no larger than the disturbance asks for, nor smaller.

    On the surface the rate of w is that of the disturbance: the equivalent of k2 sgn(sigma). L, with its
    least and largest value and rate R, follows it through a low-pass at a margin alpha::

        df/dt = omega (dw/dt - f)
        dL/dt = R sgn(L_least + alpha |f| - L)

    which ends at its target and does not switch about it. Off the surface dw/dt is 1.1 L, so that the target
    is ahead of L, which grows at its rate until the surface is reached.

    Source: Edwards, Shtessel, Int. J. Control 89(9), 2016 (dual layer; unverified), with one rate in place of
    its second layer; gains that grow off the surface and shrink on it: Shtessel, Taleb, Plestan, Automatica
    48(5), 2012 (unverified).
    Fails as SuperTwisting does while L is short; noise on the surface, over the square of the sample period,
    is a disturbance to it, which only omega quietens.
    """

    surface_gain: Annotated[float, Field("1/s", "gain c of the error in the surface", above=0)]
    least_rate: Annotated[float, Field("m/s^4", "least bound L, from which it starts", above=0)]
    largest_rate: Annotated[float, Field("m/s^4", "largest bound L", above=0)]
    growth: Annotated[float, Field("m/s^5", "rate R of L", above=0)]
    margin: Annotated[float, Field("", "alpha, L per rate of the disturbance", CHOSEN, above=1)] = 1.5
    filter_rate: Annotated[float, Field("1/s", "rate omega of the low-pass", CHOSEN, above=0)] = 200.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return twisting_assumptions(self.surface_gain, self.largest_rate, facts)

    def check(self) -> None:
        if self.largest_rate < self.least_rate:
            allowed = f"must be at least least_rate, {self.least_rate:g} [m/s^4]"
            raise ParameterError("largest_rate", self.largest_rate, allowed)

    def init(self) -> AdaptiveSuperTwistingState:
        return AdaptiveSuperTwistingState(0.0, 0.0, 0.0, 0.0, 0.0, self.least_rate, 0.0)

    def step(
        self, s: AdaptiveSuperTwistingState, error: VelocityError, dt: float
    ) -> AdaptiveSuperTwistingState:
        law = SuperTwisting(self.surface_gain, s.disturbance_rate)
        last = SuperTwistingState(s.damping, s.restoring, s.sigma, s.learnt, s.drive)
        now = law.step(last, error, dt)
        kept = ops.power(math.e, -self.filter_rate * dt)
        rate = (now.learnt - s.learnt) / dt
        filtered = rate + kept * (s.filtered - rate)
        target = ops.minimum(self.least_rate + self.margin * ops.absolute(filtered), self.largest_rate)
        most = dt * self.growth
        bound = ops.clip(target, s.disturbance_rate - most, s.disturbance_rate + most)
        return AdaptiveSuperTwistingState(
            now.damping, now.restoring, now.sigma, now.learnt, now.drive, bound, filtered
        )
