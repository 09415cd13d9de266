"""No pressure transducer."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import PressureSensor, role
from hydroservo.core.signals import Draws


class PressureReading(NamedTuple):
    """What a pressure sensor reads."""

    value: Annotated[float, Field("Pa", "measured pressure")]


@role(PressureSensor)
class NoPressure(NamedTuple):
    """The chamber's pressure is not measured: its reading is nan, and a law that uses it is refused.

    Source: a definition.
    Fails to leave the hydraulic force, which needs the pressures of both chambers.
    """

    def init(self) -> PressureReading:
        return PressureReading(math.nan)

    def step(self, s: PressureReading, pressure: float, draws: Draws, dt: float) -> PressureReading:
        return PressureReading(math.nan)
