"""A reaching law taken where it leads to."""

from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption
from hydroservo.core.roles import Reaching, role
from hydroservo.core.signals import ReachingRate

LEAST = 1e-300  # keeps the slope's power finite at the surface itself


@role(Reaching)
class ImplicitReaching(NamedTuple):
    """The reaching law evaluated at the surface of the next sample (backward Euler).

    The next surface s_next solves s_next + dt (k s_next + eps |s_next|^a sgn(s_next)) = s, and the rate is
    (s - s_next)/dt. With K = k + a eps |s_next|^(a-1) the slope is K/(1 + dt K): never above 1/dt, and that
    at the surface itself, where the continuous one is infinite. Any gain is stable at any sample period.

    Source: Acary, Brogliato, Orlov, IEEE Trans. Automatic Control 57(5), 2012, doi:10.1109/TAC.2011.2174676,
    for the implicit step; applied here to the terminal power.
    Fails to be faster than the sample period: gains above about 1/dt change nothing any more.
    """

    def supposes(self, eps: float, a: float, size: float, unit: str, dt: float) -> Sequence[Assumption]:
        """What it asks of a power on a surface: nothing."""
        return []

    def first(self, s: float, k: float, eps: float, a: float, dt: float) -> ReachingRate:
        ahead = ops.power_root(ops.absolute(s), 1.0 + dt * k, dt * eps, a)
        steepness = ops.power(ahead + LEAST, 1.0 - a)
        slope = (k * steepness + a * eps) / (steepness * (1.0 + dt * k) + dt * a * eps)
        return ReachingRate((s - ops.copysign(ahead, s)) / dt, slope)

    def second(self, s: float, k: float, eps: float, a: float, dt: float) -> float:
        return (s - ops.copysign(ops.power_root(ops.absolute(s), 1.0 + dt * k, dt * eps, a), s)) / dt
