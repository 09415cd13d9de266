"""The load pressure, as what a loop controls."""

from typing import NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class LoadPressure(NamedTuple):
    """y = p_A - p_B, the difference of both chambers' pressures.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (the load pressure of a symmetric cylinder).
    Fails to say the force of a single-rod cylinder, whose areas differ.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("Pa", "load pressure")

    def of(self, seen: Seen, command: float) -> float:
        return seen.pressure_a - seen.pressure_b

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """The supply's pressure against that of the return line, either way [Pa]."""
        return line.tank - line.supply, line.supply - line.tank
