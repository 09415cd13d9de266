"""The piston's position, as what a loop controls."""

from typing import NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class Position(NamedTuple):
    """y = x, the position of the piston from the lower end of its stroke.

    Source: a definition.
    Fails where backlash or a soft structure lies between the piston and what is to be positioned.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("m", "position")

    def of(self, seen: Seen, command: float) -> float:
        return seen.position

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """Both ends of the stroke [m]."""
        return 0.0, plant.stroke
