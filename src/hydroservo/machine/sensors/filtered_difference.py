"""Velocity from positions through a low-pass."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import VelocityEstimator, role
from hydroservo.core.signals import Draws, MachineOutputs


class FilteredDifferenceState(NamedTuple):
    """The velocity and the last position."""

    value: Annotated[float, Field("m/s", "estimated piston velocity")]
    position: Annotated[float, Field("m", "measured position at this sample")]


@role(VelocityEstimator)
class FilteredDifference(NamedTuple):
    """The backward difference through a first-order low-pass, discretised by backward Euler.

    v_k = v_(k-1) + h/(tau + h) ((y_k - y_(k-1))/h - v_(k-1)), and 0 at the first sample

    It lags by tau + h/2. A position with errors of rms r, independent from sample to sample, gives one of
    rms r sqrt(2/((tau + h)(2 tau + h))).

    Source: Astrom and Wittenmark, Computer-Controlled Systems, 1997, sec. 8.2 (the discretisation).
    Fails where the lag costs the loop more than the noise did: at a crossover frequency of about 1/(2 tau).
    """

    time_constant: Annotated[float, Field("s", "low-pass time constant tau", above=0)]

    def init(self) -> FilteredDifferenceState:
        return FilteredDifferenceState(0.0, math.nan)

    def step(
        self, s: FilteredDifferenceState, machine: MachineOutputs, position: float, draws: Draws, dt: float
    ) -> FilteredDifferenceState:
        lost = ops.isnan(s.position)  # at the start, and after a sample that was not a number
        last = ops.where(lost, position, s.position)
        before = ops.where(lost, 0.0, s.value)
        weight = dt / (self.time_constant + dt)
        return FilteredDifferenceState(before + weight * ((position - last) * (1.0 / dt) - before), position)
