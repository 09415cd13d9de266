"""A sinusoidal external force."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field

__all__ = ["Sine"]

PAPER = "doi:10.1007/s42401-021-00087-w, Sec. 4"


class Sine(NamedTuple):
    """F_L = offset + amplitude sin(2 pi frequency t + phase), positive against motion."""

    amplitude: Annotated[float, Field("N", "amplitude", PAPER)] = 100.0
    frequency: Annotated[float, Field("Hz", "frequency", PAPER, at_least=0)] = 0.25
    phase: Annotated[float, Field("rad", "phase at t = 0")] = 0.0
    offset: Annotated[float, Field("N", "mean")] = 0.0

    def force(self, t: float) -> float:
        return self.offset + self.amplitude * ops.sin(2.0 * math.pi * self.frequency * t + self.phase)
