"""An oscillator that an error drives, turned exactly."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field


class ResonatorState(NamedTuple):
    """Both numbers of the oscillator."""

    quarter: Annotated[float, Field("m", "oscillation a quarter turn behind the error's")]
    phase: Annotated[float, Field("m", "oscillation in phase with the error's")]


class Resonator(NamedTuple):
    """m := R (m + [0, h e]), with R the rotation by 2 pi f h.

    So the error of each sample enters as an impulse, and between them the oscillator's solution is exact: its
    poles lie on the unit circle, where Euler's method has them outside. At f = 0 it is an integrator.

    Source: the solution of m1' = 2 pi f m2, m2' = -2 pi f m1 + e.
    Fails beyond half the sampling frequency, where it turns at another.
    """

    frequency: Annotated[float, Field("Hz", "frequency", above=0)]

    def init(self) -> ResonatorState:
        return ResonatorState(0.0, 0.0)

    def step(self, s: ResonatorState, error: float, dt: float) -> ResonatorState:
        angle = 2.0 * math.pi * self.frequency * dt
        cosine, sine = ops.cos(angle), ops.sin(angle)
        phase = s.phase + dt * error
        return ResonatorState(cosine * s.quarter + sine * phase, cosine * phase - sine * s.quarter)
