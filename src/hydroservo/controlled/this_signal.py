"""The signal of the loop that a law is in."""

from typing import NamedTuple

from hydroservo.field import CONTROLLED, Field
from hydroservo.roles import ControlledSignal, role
from hydroservo.signals import Seen

__all__ = ["THIS_SIGNAL", "ThisSignal"]


@role(ControlledSignal)
class ThisSignal(NamedTuple):
    """In place of the signal that a law controls: that of its loop, which is filled in before a run.

    Source: a definition.
    Fails to be a loop's own; and a law that is stepped by itself, in no loop, takes the velocity.
    """

    def declared(self) -> Field:
        """What stands for the unit and the name of the loop's."""
        return Field(CONTROLLED, f"{{{CONTROLLED}}}")

    def of(self, seen: Seen, command: float) -> float:
        return seen.velocity


THIS_SIGNAL = ThisSignal()
