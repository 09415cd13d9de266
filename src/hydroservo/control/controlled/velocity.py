"""The piston's velocity, as what a loop controls."""

from typing import NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Seen


@role(ControlledSignal)
class Velocity(NamedTuple):
    """y = v, the velocity of the piston.

    Source: a definition; the controlled signal of doi:10.1007/s42401-021-00087-w.
    Fails to hold a position: errors of the velocity add up to one.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("m/s", "velocity")

    def of(self, seen: Seen, command: float) -> float:
        return seen.velocity
