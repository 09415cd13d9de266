"""A mass on the rod."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.roles import Mechanism, role

__all__ = ["Mass"]


@role(Mechanism)
class Mass(NamedTuple):
    """m dv/dt = the sum of the forces on the rod; piston and rod are part of m.

    Source: eq. (3) of doi:10.1007/s42401-021-00087-w.
    Fails on a slope, where gravity acts: give that as an external force.
    """

    mass: Annotated[float, Field("kg", "moving mass m", above=0)]

    def inertia(self, position: float) -> float:
        return self.mass

    def resistance(self, position: float, velocity: float) -> float:
        return 0.0
