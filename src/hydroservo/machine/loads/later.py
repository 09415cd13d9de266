"""A load that began before the run, and a force beside it."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role


@role(Load)
class LaterLoad(NamedTuple):
    """F(t) = F_load(t + begun) + push: a load in a run that begins at another time of it.

    Source: a definition.
    Fails where the load is asked for an instant before its own start.
    """

    load: Load
    begun: Annotated[float, Field("s", "time of the load at the start of the run")] = 0.0
    push: Annotated[float, Field("N", "force that no one recorded")] = 0.0

    def force(self, t: float) -> float:
        return self.load.force(t + self.begun) + self.push

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t + self.begun) - self.begun
