"""A mass between the rod and a spring."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Mechanism, role
from hydroservo.core.signals import Tip


@role(Mechanism)
class MassSpringDamper(NamedTuple):
    """m dv/dt = the sum of the forces on the rod - k_s (x - x_0) - b_s v, on the level.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6 (a cylinder with a spring load).
    Fails where the rod between piston and mass bends: the two are one here.
    """

    mass: Annotated[float, Field("kg", "moving mass m", above=0)]
    stiffness: Annotated[float, Field("N/m", "spring stiffness k_s", at_least=0)]
    rest_position: Annotated[float, Field("m", "position x_0 where the spring is at rest")]
    damping: Annotated[float, Field("N s/m", "damping b_s of the load", "0: none", at_least=0)] = 0.0

    def inertia(self, position: float) -> float:
        return self.mass

    def resistance(self, position: float, velocity: float) -> float:
        return self.stiffness * (position - self.rest_position) + self.damping * velocity

    def tip(self, position: float) -> Tip:
        return Tip(1.0, 0.0, 0.0, 0.0, 0.0)
