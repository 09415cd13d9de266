"""A square-wave external force."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.sources import CHOSEN

__all__ = ["Square"]


class Square(NamedTuple):
    """F_L = offset +- amplitude, starting with +, half a period each, positive against motion.

    Source: a definition; the force is that of the constant load in Sec. 4 of doi:10.1007/s42401-021-00087-w.
    Fails to keep a fixed-step integrator's order where a jump falls inside a step: let jumps fall on samples.
    """

    amplitude: Annotated[float, Field("N", "amplitude", CHOSEN)] = 100.0
    period: Annotated[float, Field("s", "period", CHOSEN, above=0)] = 4.0
    offset: Annotated[float, Field("N", "mean", CHOSEN)] = 0.0

    def force(self, t: float) -> float:
        return self.offset + self.amplitude * ops.square_wave(t, self.period)

    def next_jump(self, t: float) -> float:
        half = 0.5 * self.period
        jump = (ops.floor(t / half + 1e-9) + (1.0 - 1e-9)) * half
        return ops.where(jump > t, jump, jump + half)
