"""The force of both chambers on the piston, as what a loop controls."""

from typing import NamedTuple

from hydroservo.control.controlled.force import Force
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Pressures, Seen


@role(ControlledSignal)
class HydraulicForce(NamedTuple):
    """y = x2, the force of both chambers on the piston: A_A p_A - A_B p_B, or A_p p_L.

    Source: a definition; state x2 of doi:10.1007/s42401-021-00087-w.
    Fails to be what the rod pushes with: friction and the piston's inertia take their share.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("N", "hydraulic force")

    def of(self, seen: Seen, command: float) -> float:
        return seen.hydraulic_force

    def reach(self, plant: Block, line: Pressures) -> tuple[float, float]:
        """What the supply's pressure in one chamber against the return line's in the other makes [N]."""
        return Force().reach(plant, line)
