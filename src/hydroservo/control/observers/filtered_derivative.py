"""The derivative of a sampled signal, from a low-pass filtered difference."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Differentiator, role
from hydroservo.core.sources import CHOSEN


class FilteredDerivativeState(NamedTuple):
    """The filtered rate and the last sample."""

    rate: Annotated[float, Field("", "estimated rate, in the signal's unit per second")]
    last: Annotated[float, Field("", "the signal at the sample before, in its own unit")]


@role(Differentiator)
class FilteredDerivative(NamedTuple):
    """Backward difference through a first-order low-pass, discretised by backward Euler.

    rate_k = rate_(k-1) + dt/(tau + dt) ((x_k - x_(k-1))/dt - rate_(k-1))

    Source: chosen for the reproduction of doi:10.1007/s42401-021-00087-w, which gives no way to form the
    derivative of d_hat_L1 that its eq. (22) needs.
    Fails by a lag of tau, and amplifies noise above 1/tau by 1/tau.
    """

    time_constant: Annotated[float, Field("s", "low-pass time constant tau", CHOSEN, at_least=0)] = 1e-3

    def init(self) -> FilteredDerivativeState:
        return FilteredDerivativeState(0.0, math.nan)

    def step(
        self, s: FilteredDerivativeState, value: float, model_rate: float, dt: float
    ) -> FilteredDerivativeState:
        lost = ops.isnan(s.last)  # at the start, and after a sample that was not a number
        last = ops.where(lost, value, s.last)
        rate = ops.where(lost, 0.0, s.rate)
        weight = dt / (self.time_constant + dt)
        return FilteredDerivativeState(rate + weight * ((value - last) * (1.0 / dt) - rate), value)
