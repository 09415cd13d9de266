"""What the supply's pressure comes to."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role


class SupplyLineState(NamedTuple):
    """How many instants, the pressure at the first, and extremes so far."""

    instants: float
    first: float
    low: float
    high: float


class SupplyLineValues(NamedTuple):
    """What it comes to; nan where the run ended before there was any."""

    supply_pressure_min: Annotated[
        float, Field("Pa", "lowest gauge pressure of the supply", least_is_worst=True)
    ]
    supply_pressure_max: Annotated[float, Field("Pa", "highest gauge pressure of the supply")]
    supply_pressure_dip: Annotated[
        float,
        Field("Pa", "how far the supply's pressure falls below that at the start", smaller_is_better=True),
    ]


@role(Monitor)
class SupplyLine(NamedTuple):
    """The lowest and the highest pressure of the supply, and how far it falls below that at the start.

    Source: a definition.
    Fails to see the pressure of a pump that a drive has for itself, as LoadSensing and PumpDrive do.
    """

    def init(self) -> SupplyLineState:
        return SupplyLineState(0.0, 0.0, math.inf, -math.inf)

    def step(self, m: SupplyLineState, loop: Block, s: Block, t: float, dt: float) -> SupplyLineState:
        pressure = loop.supply.pressures(s.supply).supply
        return SupplyLineState(
            instants=m.instants + 1.0,
            first=ops.where(m.instants == 0.0, pressure, m.first),
            low=ops.minimum(pressure, m.low),
            high=ops.maximum(pressure, m.high),
        )

    def values(self, m: SupplyLineState) -> SupplyLineValues:
        if m.instants == 0.0:
            return SupplyLineValues(math.nan, math.nan, math.nan)
        return SupplyLineValues(m.low, m.high, m.first - m.low)
