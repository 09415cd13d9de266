"""The pressure in chamber A, as what a loop controls."""

from typing import NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class PressureA(NamedTuple):
    """y = p_A, the pressure in chamber A; gauge, as all pressures.

    Source: a definition.
    Fails to say how much of it is lost in a line between the chamber and its sensor.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("Pa", "pressure A")

    def of(self, seen: Seen, command: float) -> float:
        return seen.pressure_a

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """From absolute zero to the supply's pressure [Pa]."""
        return -ATMOSPHERE, line.supply
