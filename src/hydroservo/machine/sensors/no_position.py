"""No position sensor."""

import math
from typing import NamedTuple

from hydroservo.core.roles import PositionSensor, role
from hydroservo.core.signals import Draws
from hydroservo.machine.sensors.ideal_position import PositionReading


@role(PositionSensor)
class NoPosition(NamedTuple):
    """The position is not measured: its reading is nan, and a law that uses it is refused.

    Source: a definition.
    Fails with a velocity estimator that needs the position: the velocity is not measured either then.
    """

    def init(self) -> PositionReading:
        return PositionReading(math.nan)

    def step(self, s: PositionReading, position: float, draws: Draws, dt: float) -> PositionReading:
        return PositionReading(math.nan)
