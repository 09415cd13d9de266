"""A reaching law taken at the sample."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, below
from hydroservo.core.block import Field
from hydroservo.core.roles import Reaching, role
from hydroservo.core.signals import ReachingRate
from hydroservo.core.sources import CHOSEN


@role(Reaching)
class ExplicitReaching(NamedTuple):
    """k s + eps |s|^a sgn(s) at the measured surface (forward Euler).

    Its slope k + a eps |s|^(a-1), singular at s = 0, is taken at |s| + ``least_surface``.

    Source: eqs. (21)-(22) of doi:10.1007/s42401-021-00087-w.
    Fails where k times the sample period nears 1, and chatters within about (eps dt)^(1/(1-a)) of s = 0.
    """

    least_surface: Annotated[
        float, Field("m/s", "keeps |xi1|^(a1-1) finite in the slope", CHOSEN, above=0)
    ] = 1e-4

    def supposes(self, eps: float, a: float, size: float, unit: str, dt: float) -> Sequence[Assumption]:
        """What it asks of a power on a surface that the demand makes so large."""
        band = (eps * dt) ** (1.0 / (1.0 - a))
        meaning = "the band in which it chatters is below 1 % of the surface"
        return [below("explicit power", meaning, band, 0.01 * size, unit)]

    def first(self, s: float, k: float, eps: float, a: float, dt: float) -> ReachingRate:
        slope = a * ops.power(ops.absolute(s) + self.least_surface, a - 1.0)
        return ReachingRate(k * s + eps * ops.signed_power(s, a), k + eps * slope)

    def second(self, s: float, k: float, eps: float, a: float, dt: float) -> float:
        return k * s + eps * ops.signed_power(s, a)
