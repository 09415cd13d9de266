"""An external force that jumps once."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role
from hydroservo.core.sources import CHOSEN


@role(Load)
class Step(NamedTuple):
    """F_L = initial before the switching instant, final from it on, positive against motion.

    Source: a definition.
    Fails to keep a fixed-step integrator's order where the jump falls inside a step: let it fall on a sample.
    """

    initial: Annotated[float, Field("N", "force before the step")]
    final: Annotated[float, Field("N", "force from the step on")]
    time: Annotated[float, Field("s", "switching instant", CHOSEN, at_least=0)] = 0.1

    def force(self, t: float) -> float:
        return ops.where(ops.at_or_after(t, self.time), self.final, self.initial)

    def next_jump(self, t: float) -> float:
        return ops.where(ops.at_or_after(t, self.time), math.inf, self.time)
