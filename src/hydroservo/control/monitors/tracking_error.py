"""How far the controlled signal is from its demand."""

import math
from typing import Annotated, NamedTuple

from hydroservo.control.monitors.second_half import HALF
from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, role


class TrackingErrorState(NamedTuple):
    """Integrals and extremes so far; the steady ones begin at half the duration."""

    squares: float
    time: float
    largest: float
    steady_squares: float
    steady_time: float
    steady_largest: float
    last: float  # size of the error, which counts once time has passed


class TrackingErrorValues(NamedTuple):
    """What it comes to; nan where the run ended before there was any."""

    rms_error: Annotated[float, Field("y", "rms of the {y} error", smaller_is_better=True)]
    max_error: Annotated[float, Field("y", "largest {y} error", smaller_is_better=True)]
    steady_rms_error: Annotated[
        float, Field("y", "rms of the {y} error, second half", smaller_is_better=True)
    ]
    steady_max_error: Annotated[float, Field("y", "largest {y} error, second half", smaller_is_better=True)]


@role(Monitor)
class TrackingError(NamedTuple):
    """The error e = r - y of the controlled signal over the run and over its second half.

    rms = sqrt(1/T integral of e^2 dt), the integral by the left rule over the integrator's steps, so that
    what happens between samples counts. A demand that jumps at the very end asks for what no time is left
    for: the error there does not count.

    Source: a definition.
    Fails to see what happens inside a step, where steps are long.
    """

    def init(self) -> TrackingErrorState:
        return TrackingErrorState(*[0.0] * len(TrackingErrorState._fields))

    def step(self, m: TrackingErrorState, loop: Block, s: Block, t: float, dt: float) -> TrackingErrorState:
        error = s.reference.value - s.controlled.value
        squares = error * error * dt
        steady = t >= HALF * loop.simulation.duration
        return TrackingErrorState(
            squares=m.squares + squares,
            time=t + dt,
            largest=ops.maximum(m.last, m.largest),
            steady_squares=m.steady_squares + ops.where(steady, squares, 0.0),
            steady_time=m.steady_time + ops.where(steady, dt, 0.0),
            steady_largest=ops.maximum(ops.where(m.steady_time > 0.0, m.last, 0.0), m.steady_largest),
            last=ops.absolute(error),
        )

    def values(self, m: TrackingErrorState) -> TrackingErrorValues:
        steady = m.steady_time > 0.0
        return TrackingErrorValues(
            math.sqrt(m.squares / m.time) if m.time > 0.0 else math.nan,
            m.largest if m.time > 0.0 else math.nan,
            math.sqrt(m.steady_squares / m.steady_time) if steady else math.nan,
            m.steady_largest if steady else math.nan,
        )
