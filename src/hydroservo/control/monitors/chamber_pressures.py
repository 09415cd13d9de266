"""What the pressures in the chambers come to."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.sources import CHOSEN


class ChamberPressuresState(NamedTuple):
    """Extremes so far."""

    low: float
    high: float
    below: float  # [s]


class ChamberPressuresValues(NamedTuple):
    """What it comes to; nan where the run ended before there was any."""

    pressure_min: Annotated[float, Field("Pa", "lowest gauge pressure in a chamber", least_is_worst=True)]
    pressure_max: Annotated[float, Field("Pa", "highest gauge pressure in a chamber")]
    low_pressure_time: Annotated[
        float, Field("s", "time with a chamber below the threshold", smaller_is_better=True)
    ]


@role(Monitor)
class ChamberPressures(NamedTuple):
    """The lowest and the highest pressure in a chamber, and how long one was below a threshold.

    Source: a definition.
    Fails for a plant that knows its load pressure alone: it has no chambers.
    """

    threshold: Annotated[float, Field("Pa", "gauge pressure below which the time counts", CHOSEN)] = 0.0

    def init(self) -> ChamberPressuresState:
        return ChamberPressuresState(math.inf, -math.inf, 0.0)

    def step(
        self, m: ChamberPressuresState, loop: Block, s: Block, t: float, dt: float
    ) -> ChamberPressuresState:
        low = ops.minimum(s.plant.pressure_a, s.plant.pressure_b)
        high = ops.maximum(s.plant.pressure_a, s.plant.pressure_b)
        return ChamberPressuresState(
            ops.minimum(low, m.low),
            ops.maximum(high, m.high),
            m.below + ops.where(low < self.threshold, dt, 0.0),
        )

    def values(self, m: ChamberPressuresState) -> ChamberPressuresValues:
        known = m.low <= m.high
        return ChamberPressuresValues(*((m.low, m.high) if known else (math.nan, math.nan)), m.below)
