"""How the controlled signal follows the jumps of its demand."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.sources import CHOSEN

ROUNDING = 1e-12  # of what rates explain


class StepResponseState(NamedTuple):
    """The demand as it was, its last jump, and the longest and largest so far."""

    last_demand: float
    last_rate: float
    last_step: float  # [s]
    start: float  # the signal at the start, from which demands are counted
    demand_max: float
    jump_time: float
    jump_sign: float  # 0 before the first
    settling: float
    overshoot: float


class StepResponseValues(NamedTuple):
    """What it comes to."""

    settling_time: Annotated[
        float,
        Field("s", "longest time from a jump until within the band", smaller_is_better=True),
    ]
    overshoot: Annotated[
        float,
        Field(
            "y",
            "furthest beyond the demand in the direction of its last jump; 0 without a jump",
            smaller_is_better=True,
        ),
    ]
    demand_reach: Annotated[float, Field("y", "furthest that the demand goes from the signal at the start")]
    demand_jumps: Annotated[bool, Field("", "the demand jumps, the start from rest included")]


@role(Monitor)
class StepResponse(NamedTuple):
    """Settling time and overshoot after the jumps of a demand.

    A jump is a change of the demand, beyond what its rates at both instants explain, of more than the band;
    the start from rest counts, a kink does not, and ``demand_jumps`` says whether there was one.
    ``settling_time`` is the longest time from a jump (or the start) until the error is last outside the band,
    which is a share of ``demand_reach``, the largest demand so far, counted from the signal at the start.
    ``overshoot`` is the furthest that the signal goes beyond the demand in the direction of its last jump, 0
    without one. A demand that jumps at the very end, by however little, asks for what no time is left for:
    there the signal is held against the demand before.

    Source: Ogata, Modern Control Engineering, 2010, sec. 5-3; what counts as a jump is chosen here.
    Fails for a demand that gets to its end without a jump, as a Ramp or a PointToPoint: its overshoot is 0,
    whatever the signal does, and the tracking error tells more. One that changes as much as the band within a
    step may be taken for one that jumps.
    """

    band: Annotated[
        float, Field("", "share of the largest demand so far that the error must stay in", CHOSEN, above=0)
    ] = 0.05

    def init(self) -> StepResponseState:
        return StepResponseState(*[0.0] * len(StepResponseState._fields))

    def step(self, m: StepResponseState, loop: Block, s: Block, t: float, dt: float) -> StepResponseState:
        demand, rate = s.reference.value, s.reference.rate
        first = m.last_step == 0.0
        start = ops.where(first, s.controlled.value, m.start)
        half = 0.5 * m.last_step
        jump = demand - ops.where(first, start, m.last_demand) - half * (m.last_rate + rate)
        asked = ops.where(dt > 0.0, demand, demand - jump)
        demand_max = ops.maximum(m.demand_max, ops.absolute(asked - start))
        band = self.band * demand_max
        kink = half * ops.absolute(rate - m.last_rate)
        rounding = ROUNDING * half * (ops.absolute(rate) + ops.absolute(m.last_rate))
        jumped = dt > 0.0 and ops.absolute(jump) - kink > ops.maximum(band, rounding)
        error = asked - s.controlled.value
        jump_time = ops.where(jumped, t, m.jump_time)
        jump_sign = ops.where(jumped, ops.sign(jump), m.jump_sign)
        outside = ops.where(ops.absolute(error) > band, t - jump_time, 0.0)
        return StepResponseState(
            last_demand=demand,
            last_rate=rate,
            last_step=dt,
            start=start,
            demand_max=demand_max,
            jump_time=jump_time,
            jump_sign=jump_sign,
            settling=ops.maximum(outside, m.settling),
            overshoot=ops.maximum(-jump_sign * error, m.overshoot),
        )

    def values(self, m: StepResponseState) -> StepResponseValues:
        return StepResponseValues(m.settling, m.overshoot, m.demand_max, m.jump_sign != 0.0)
