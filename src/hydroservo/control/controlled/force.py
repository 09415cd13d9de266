"""The force at the rod, as what a loop controls."""

import math
from typing import NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class Force(NamedTuple):
    """y = F, the force with which the rod pushes against what resists it: a load cell at its end.

    Source: a definition; the resistance of the plant's mechanism and the external force, without inertia.
    Fails where a heavy mass lies between the load cell and what is pushed: its inertia is not in F.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("N", "force")

    def of(self, seen: Seen, command: float) -> float:
        return seen.force

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """What the supply's pressure in one chamber against the return line's in the other holds [N]."""
        only = getattr(plant, "piston_area", math.inf)
        area_a, area_b = getattr(plant, "area_a", only), getattr(plant, "area_b", only)
        return area_a * line.tank - area_b * line.supply, area_a * line.supply - area_b * line.tank
