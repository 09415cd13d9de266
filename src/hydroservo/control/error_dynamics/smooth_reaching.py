"""A reaching law made linear within a boundary layer."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, below
from hydroservo.core.block import Field
from hydroservo.core.roles import Reaching, role
from hydroservo.core.signals import ReachingRate
from hydroservo.core.sources import CHOSEN


@role(Reaching)
class SmoothReaching(NamedTuple):
    """k s + eps s (|s| + phi)^(a-1): the terminal power where |s| is large, linear within the layer phi.

    Source: Slotine and Li, Applied Nonlinear Control, 1991, sec. 7.2, for the boundary layer; applied here
    to the terminal power, whose slope at s = 0 becomes k + eps phi^(a-1).
    Fails where that slope times the sample period nears 1. Inside the layer the surface falls exponentially,
    and no longer in finite time.
    """

    first_thickness: Annotated[float, Field("m/s", "boundary layer on xi1", CHOSEN, above=0)] = 1e-3
    second_thickness: Annotated[float, Field("m/s^2", "boundary layer on xi2", CHOSEN, above=0)] = 1.0

    def supposes(self, eps: float, a: float, size: float, unit: str, dt: float) -> Sequence[Assumption]:
        """What it asks of a power on a surface that the demand makes so large."""
        thickness = self.first_thickness if unit == "m/s" else self.second_thickness
        slope = eps * thickness ** (a - 1.0)
        return [below("boundary layer", "the slope in the layer is below 1/h", slope, 1.0 / dt, "1/s")]

    def first(self, s: float, k: float, eps: float, a: float, dt: float) -> ReachingRate:
        size = ops.absolute(s) + self.first_thickness
        gain = eps * ops.power(size, a - 1.0)
        return ReachingRate((k + gain) * s, k + gain * (1.0 + (a - 1.0) * ops.absolute(s) / size))

    def second(self, s: float, k: float, eps: float, a: float, dt: float) -> float:
        return (k + eps * ops.power(ops.absolute(s) + self.second_thickness, a - 1.0)) * s
