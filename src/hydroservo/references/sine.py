"""A sinusoidal velocity demand."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.signals import Demand

__all__ = ["Sine"]

PAPER = "doi:10.1007/s42401-021-00087-w, Sec. 4"


class Sine(NamedTuple):
    """offset + amplitude sin(2 pi frequency t + phase), with its exact derivatives."""

    amplitude: Annotated[float, Field("m/s", "amplitude", PAPER)] = 0.03
    frequency: Annotated[float, Field("Hz", "frequency", PAPER, at_least=0)] = 0.25
    phase: Annotated[float, Field("rad", "phase at t = 0")] = 0.0
    offset: Annotated[float, Field("m/s", "mean")] = 0.0

    def at(self, t: float) -> Demand:
        omega = 2.0 * math.pi * self.frequency
        angle = omega * t + self.phase
        value = self.amplitude * ops.sin(angle)
        rate = self.amplitude * omega * ops.cos(angle)
        return Demand(self.offset + value, rate, -omega * omega * value)
