"""Velocity from two positions."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import VelocityEstimator, role
from hydroservo.core.signals import Draws, MachineOutputs


class DifferenceState(NamedTuple):
    """The velocity and the last position."""

    value: Annotated[float, Field("m/s", "estimated piston velocity")]
    position: Annotated[float, Field("m", "measured position at this sample")]


@role(VelocityEstimator)
class Difference(NamedTuple):
    """The backward difference of the measured position: v_k = (y_k - y_(k-1))/h, and 0 at the first sample.

    It is the mean velocity over the last period, so it lags by h/2. A position rounded to counts q adds an
    error within +-q/h: at a constant speed of n + f counts a period one of rms q sqrt(f (1 - f))/h, and
    q/(sqrt(6) h) over all speeds, as if the two roundings were independent.

    Source: a definition; Widrow and Kollar, Quantization Noise, 2008, ch. 1.
    Fails at short periods: at 10 kHz a count of 1 um is 10 mm/s.
    """

    def init(self) -> DifferenceState:
        return DifferenceState(0.0, math.nan)

    def step(
        self, s: DifferenceState, machine: MachineOutputs, position: float, draws: Draws, dt: float
    ) -> DifferenceState:
        last = ops.where(ops.isnan(s.position), position, s.position)
        return DifferenceState((position - last) * (1.0 / dt), position)
