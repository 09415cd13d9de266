"""A mass on the rod."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import GRAVITY
from hydroservo.core.roles import Mechanism, role
from hydroservo.core.signals import Tip
from hydroservo.core.sources import CHOSEN


@role(Mechanism)
class Mass(NamedTuple):
    """m dv/dt = the sum of the forces on the rod - m g r; piston and rod are part of m.

    The rise r is the sine of the angle by which the rod's way out climbs: 0 on the level, 1 where it pushes
    the mass straight up, -1 where it lets it down. What the mass carries hangs from it.

    Source: eq. (3) of doi:10.1007/s42401-021-00087-w; its weight on a slope from statics.
    Fails where the rod between piston and mass bends: the two are one here.
    """

    mass: Annotated[float, Field("kg", "moving mass m", above=0)]
    rise: Annotated[
        float, Field("", "rise r of the way out: 0 level, 1 straight up", "level", at_least=-1, at_most=1)
    ] = 0.0
    gravity: Annotated[float, Field("m/s^2", "acceleration g of free fall", CHOSEN)] = GRAVITY

    def inertia(self, position: float) -> float:
        return self.mass

    def resistance(self, position: float, velocity: float) -> float:
        return self.mass * self.gravity * self.rise

    def tip(self, position: float) -> Tip:
        return Tip(ops.sqrt(1.0 - self.rise * self.rise), self.rise, 0.0, 0.0, 0.0)
