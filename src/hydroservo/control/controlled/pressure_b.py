"""The pressure in chamber B, as what a loop controls."""

from typing import NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class PressureB(NamedTuple):
    """y = p_B, the pressure in chamber B; gauge, as all pressures.

    Source: a definition.
    Fails under laws that raise the command to raise it: p_B falls as the piston is driven out, so that a gain
    above 0 drives it the wrong way. Put InvertedPolarity around them.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("Pa", "pressure B")

    def of(self, seen: Seen, command: float) -> float:
        return seen.pressure_b

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """From absolute zero to the supply's pressure [Pa]."""
        return -ATMOSPHERE, line.supply
