"""Where the piston goes."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role


class PistonTravelState(NamedTuple):
    """Extremes so far, and the stroke that the piston has [m]."""

    low: float
    high: float
    stroke: float


class PistonTravelValues(NamedTuple):
    """What it comes to; nan where the run ended before there was any."""

    position_min: Annotated[float, Field("m", "lowest piston position", least_is_worst=True)]
    position_max: Annotated[float, Field("m", "highest piston position")]
    stroke_left: Annotated[bool, Field("", "the piston left its stroke")]


@role(Monitor)
class PistonTravel(NamedTuple):
    """The lowest and the highest position of the piston, and whether it left its stroke.

    Source: a definition.
    Fails to see what happens inside a step, where steps are long.
    """

    def init(self) -> PistonTravelState:
        return PistonTravelState(math.inf, -math.inf, math.inf)

    def step(self, m: PistonTravelState, loop: Block, s: Block, t: float, dt: float) -> PistonTravelState:
        position = s.plant.position
        return PistonTravelState(
            ops.minimum(position, m.low), ops.maximum(position, m.high), loop.plant.stroke
        )

    def values(self, m: PistonTravelState) -> PistonTravelValues:
        known = m.low <= m.high
        low, high = (m.low, m.high) if known else (math.nan, math.nan)
        return PistonTravelValues(low, high, m.low < 0.0 or m.high > m.stroke)
