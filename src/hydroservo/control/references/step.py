"""A demand that jumps once."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Step(NamedTuple):
    """r = initial before the switching instant, final from it on; both derivatives are 0.

    An instant that falls short of the switching one by less than 1e-9 of it counts as there.

    Source: a definition.
    Fails as a demand for laws that use its derivatives: the jump is not in them.
    """

    initial: Annotated[float, Field("y", "demand before the step")]
    final: Annotated[float, Field("y", "demand from the step on")]
    time: Annotated[float, Field("s", "switching instant", CHOSEN, at_least=0)] = 0.1

    def at(self, t: float) -> Demand:
        return Demand(ops.where(ops.reached(t, self.time), self.final, self.initial), 0.0, 0.0)
