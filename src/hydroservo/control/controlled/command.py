"""The command itself, as what a loop controls: an open loop."""

from typing import NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Seen


@role(ControlledSignal)
class Command(NamedTuple):
    """y = u: nothing of the machine is controlled, and the demand is the command that it is given.

    Source: a definition; the excitation of an identification or a frequency response.
    Fails to hold the machine anywhere: it drifts, to the end of its stroke in time.
    """

    def declared(self) -> Field:
        """Its unit and its name."""
        return Field("V", "command")

    def of(self, seen: Seen, command: float) -> float:
        return command
