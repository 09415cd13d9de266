"""A square-wave external force."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role
from hydroservo.core.sources import CHOSEN


@role(Load)
class Square(NamedTuple):
    """F_L = offset +- amplitude, starting with +, half a period each, positive against motion.

    Source: a definition.
    Fails to keep a fixed-step integrator's order where a jump falls inside a step: let jumps fall on samples.
    """

    amplitude: Annotated[float, Field("N", "amplitude")]
    period: Annotated[float, Field("s", "period", above=0)]
    offset: Annotated[float, Field("N", "mean", CHOSEN)] = 0.0

    def force(self, t: float) -> float:
        begun = self.begun(t)
        sign = ops.where(begun - 2.0 * ops.floor(0.5 * begun) == 0.0, 1.0, -1.0)
        return self.offset + self.amplitude * sign

    def next_jump(self, t: float) -> float:
        return (self.begun(t) + 1.0) * (0.5 * self.period)

    def begun(self, t: float) -> float:
        """How many half periods have passed."""
        half = 0.5 * self.period
        nearest = ops.floor(t / half + 0.5)
        return ops.where(ops.at_or_after(t, nearest * half), nearest, nearest - 1.0)
