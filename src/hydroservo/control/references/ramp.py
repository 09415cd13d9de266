"""A demand that changes at a constant rate."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Ramp(NamedTuple):
    """r = initial, then at a constant rate to final, which is held.

    With s the sign of final - initial, from the start of the ramp until final is reached::

        r = initial + s rate (t - time)

    At a corner the rate is that of the section which begins there; an instant that falls short of a corner by
    less than 1e-9 of its distance counts as there.

    Source: a definition; the first section of a trapezoidal profile.
    Fails as a demand for laws that use its second derivative: the jumps of its rate are not in that.
    """

    initial: Annotated[float, Field("y", "demand before the ramp")]
    final: Annotated[float, Field("y", "demand after the ramp")]
    rate: Annotated[float, Field("y/s", "size of the demand's rate", above=0)]
    time: Annotated[float, Field("s", "start of the ramp", CHOSEN, at_least=0)] = 0.1

    def at(self, t: float) -> Demand:
        change = self.final - self.initial
        gained = self.rate * ops.maximum(t - self.time, 0.0)
        started = ops.reached(t, self.time)
        ended = ops.reached(gained, ops.absolute(change))
        moving = self.initial + ops.copysign(gained, change)
        value = ops.where(ended, self.final, moving)
        rate = ops.where(ended, 0.0, ops.copysign(self.rate, change))
        return Demand(ops.where(started, value, self.initial), ops.where(started, rate, 0.0), 0.0)
