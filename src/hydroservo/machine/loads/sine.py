"""A sinusoidal external force."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Load, role
from hydroservo.core.sources import CHOSEN


@role(Load)
class Sine(NamedTuple):
    """F_L = offset + amplitude sin(2 pi frequency t + phase), positive against motion.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w, whose load has no phase and no offset.
    Fails where the force depends on the motion, as that of a spring or of friction does.
    """

    amplitude: Annotated[float, Field("N", "amplitude")]
    frequency: Annotated[float, Field("Hz", "frequency", at_least=0)]
    phase: Annotated[float, Field("rad", "phase at t = 0", CHOSEN)] = 0.0
    offset: Annotated[float, Field("N", "mean", CHOSEN)] = 0.0

    def force(self, t: float) -> float:
        return self.offset + self.amplitude * ops.sin(2.0 * math.pi * self.frequency * t + self.phase)

    def next_jump(self, t: float) -> float:
        return math.inf
