"""A load that began before the run, and a force beside it."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role


@role(Load)
class LaterLoad(NamedTuple):
    """F(t) = F_load(t + t_0) + push: a load that is t_0 old when the run begins, and a force.

    Source: a definition.
    Fails where the load is asked for an instant before its own start.
    """

    load: Load
    begins: Annotated[float, Field("s", "the instant t_0")] = 0.0
    push: Annotated[float, Field("N", "force that no one recorded")] = 0.0

    def force(self, t: float) -> float:
        return self.load.force(t + self.begins) + self.push

    def next_jump(self, t: float) -> float:
        return self.load.next_jump(t + self.begins) - self.begins
