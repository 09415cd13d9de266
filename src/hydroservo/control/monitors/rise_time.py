"""How long the controlled signal takes to rise to its demand."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.sources import CHOSEN


class RiseTimeState(NamedTuple):
    """The demand as it was, and the rise that is under way."""

    demand: float
    rate: float
    first: float  # the signal at the start of the run, from which demands are counted
    demand_max: float
    last_step: float  # [s]
    start: float  # the controlled signal at the last jump
    size: float  # from there to the demand then; 0 before the first
    low_time: float  # when the signal was at the low share of its way [s]; nan before
    under_way: float  # 1 until it is at the high share
    longest: float  # [s]; nan before the first


class RiseTimeValues(NamedTuple):
    """What it comes to."""

    rise_time: Annotated[
        float,
        Field(
            "s",
            "longest rise to a jump of the demand; nan without one, inf if one was not followed",
            smaller_is_better=True,
        ),
    ]


@role(Monitor)
class RiseTime(NamedTuple):
    """The longest time from a tenth to nine tenths of the way from the signal at a jump to the demand then.

    A jump is a change of the demand, beyond what its rates at both instants explain, of more than
    ``least_jump`` of the largest demand so far, counted from the signal at the start. A rise that the next
    jump or the end of the run cuts off has not followed, and counts as infinite.

    Source: Ogata, Modern Control Engineering, 2010, sec. 5-3.
    Fails where the signal passes the low share within the step after the jump: the rise seems shorter by
    it.
    """

    low: Annotated[
        float, Field("", "share of the way from which on it counts", CHOSEN, at_least=0, below=1)
    ] = 0.1
    high: Annotated[float, Field("", "share of the way at which it ends", CHOSEN, above=0, at_most=1)] = 0.9
    least_jump: Annotated[
        float, Field("", "share of the largest demand so far that counts as a jump", CHOSEN, above=0)
    ] = 0.05

    def init(self) -> RiseTimeState:
        return RiseTimeState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, math.nan, 0.0, math.nan)

    def step(self, m: RiseTimeState, loop: Block, s: Block, t: float, dt: float) -> RiseTimeState:
        demand, rate, signal = s.reference.value, s.reference.rate, s.controlled.value
        beginning, half = m.last_step == 0.0, 0.5 * m.last_step
        first = ops.where(beginning, signal, m.first)
        demand_max = ops.maximum(m.demand_max, ops.absolute(demand - first))
        least = self.least_jump * demand_max
        jump = demand - ops.where(beginning, first, m.demand) - half * (m.rate + rate)
        jumped = dt > 0.0 and ops.absolute(jump) - half * ops.absolute(rate - m.rate) > least
        start = ops.where(jumped, signal, m.start)
        size = ops.where(jumped, demand - signal, m.size)
        way = ops.where(size == 0.0, 1.0, (signal - start) / ops.where(size == 0.0, 1.0, size))
        before = ops.where(jumped, math.nan, m.low_time)
        low_time = ops.where(ops.isnan(before) and way >= self.low, t, before)
        under_way = ops.where(jumped, 1.0, m.under_way)
        risen = under_way > 0.0 and way >= self.high
        longest = ops.where(jumped and m.under_way > 0.0, math.inf, m.longest)
        known = ops.where(ops.isnan(longest), 0.0, longest)
        return RiseTimeState(
            demand=demand,
            rate=rate,
            first=first,
            demand_max=demand_max,
            last_step=dt,
            start=start,
            size=size,
            low_time=low_time,
            under_way=ops.where(risen, 0.0, under_way),
            longest=ops.where(risen, ops.maximum(t - low_time, known), longest),
        )

    def values(self, m: RiseTimeState) -> RiseTimeValues:
        return RiseTimeValues(math.inf if m.under_way > 0.0 else m.longest)
