"""A sinusoidal demand."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Sine(NamedTuple):
    """r = offset + amplitude sin(2 pi frequency t + phase), with its exact derivatives.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w, whose demand has no phase and no offset.
    Fails as a start from rest where phase or offset makes the first value other than 0: that is a step.
    """

    amplitude: Annotated[float, Field("y", "amplitude")]
    frequency: Annotated[float, Field("Hz", "frequency", at_least=0)]
    phase: Annotated[float, Field("rad", "phase at t = 0", CHOSEN)] = 0.0
    offset: Annotated[float, Field("y", "mean", CHOSEN)] = 0.0

    def at(self, t: float) -> Demand:
        omega = 2.0 * math.pi * self.frequency
        angle = omega * t + self.phase
        value = self.amplitude * ops.sin(angle)
        rate = self.amplitude * omega * ops.cos(angle)
        return Demand(self.offset + value, rate, -omega * omega * value)
