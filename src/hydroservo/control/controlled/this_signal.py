"""The signal of the loop that a law is in."""

import math
from typing import NamedTuple

from hydroservo.core.field import CONTROLLED, Field
from hydroservo.core.roles import ControlledSignal, role
from hydroservo.core.signals import Seen


@role(ControlledSignal)
class ThisSignal(NamedTuple):
    """In place of the signal that a law controls: that of its loop.

    It is filled in at the start of a run, by ``hydroservo.runs.run.runnable_loop``, and not by
    :func:`~hydroservo.control.wiring.wired`: a loop that is loaded or wired may yet be given another signal.

    Source: a definition.
    Fails to be a loop's own; and gives a law that is stepped by itself, in no loop, nan: tell that its
    signal, as ``PI(3.0, controls=Velocity())``.
    """

    def declared(self) -> Field:
        """What stands for the unit and the name of the loop's."""
        return Field(CONTROLLED, f"{{{CONTROLLED}}}")

    def of(self, seen: Seen, command: float) -> float:
        return math.nan


THIS_SIGNAL = ThisSignal()
