"""A load that began before the run, and a force beside it."""

from typing import Annotated, Any, NamedTuple

from hydroservo.block import Field
from hydroservo.roles import Load

PUSH = "load.push"


class Later(NamedTuple):
    """F(t) = F_load(t + begun) + push: the load of a scenario, in a run that begins at another time of it.

    Source: a definition.
    Fails to know when a periodic load began where the clock of a log is not that of the scenario.
    """

    load: Load
    begun: Annotated[float, Field("s", "time of the load at the start of the run")] = 0.0
    push: Annotated[float, Field("N", "force that no one recorded")] = 0.0

    def force(self, t: float) -> float:
        return self.load.force(t + self.begun) + self.push

    def next_jump(self, t: float) -> Any:
        return self.load.next_jump(t + self.begun) - self.begun
