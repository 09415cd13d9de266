"""The lumped disturbances, and how well an observer knows them."""

import math
from typing import Annotated, NamedTuple

from hydroservo.control.monitors.second_half import HALF
from hydroservo.core import ops
from hydroservo.core.block import Block, estimates_in, model_in
from hydroservo.core.field import Field
from hydroservo.core.roles import Monitor, at_samples, role


class DisturbanceState(NamedTuple):
    """The disturbances at the last sample, and sums so far; the steady ones begin at half the duration."""

    d1: Annotated[float, Field("m/s^2", "lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "lumped disturbance d_L2")]
    samples: float
    squares_1: float
    squares_2: float
    largest_1: float
    largest_2: float
    misses_1: float
    misses_2: float


class DisturbanceValues(NamedTuple):
    """What it comes to; nan where the run ended before there was any."""

    estimate_rms_error_1: Annotated[
        float, Field("m/s^2", "rms error of the estimate of d_L1, second half", smaller_is_better=True)
    ]
    estimate_rms_error_2: Annotated[
        float, Field("N/s", "rms error of the estimate of d_L2, second half", smaller_is_better=True)
    ]
    disturbance_rms_1: Annotated[float, Field("m/s^2", "rms of d_L1, second half")]
    disturbance_rms_2: Annotated[float, Field("N/s", "rms of d_L2, second half")]
    disturbance_max_1: Annotated[float, Field("m/s^2", "largest |d_L1|")]
    disturbance_max_2: Annotated[float, Field("N/s", "largest |d_L2|")]


@role(Monitor)
@at_samples
class Disturbance(NamedTuple):
    """What the machine does besides the model that its law believes in, and what the law's observer misses.

    d_L1 = dx1/dt - f1(x1) - g1 x2,   d_L2 = dx2/dt - f2(x1, x2) - g2(x2, u) u

    with the machine's true rates, at the samples, where estimates are made.

    Source: eq. (6) of doi:10.1007/s42401-021-00087-w.
    Fails for a law that has no model of the machine, or whose observer makes no estimates d1 and d2.
    """

    def init(self) -> DisturbanceState:
        return DisturbanceState(*[0.0] * len(DisturbanceState._fields))

    def step(self, m: DisturbanceState, loop: Block, s: Block, t: float, dt: float) -> DisturbanceState:
        model, estimates = model_in(loop.controller), estimates_in(s.controller)
        held = loop.held(s)
        u, rate = loop.hold.at(held, t), loop.deriv(t, loop.machine(s), held).plant
        x1, x2 = s.plant.velocity, loop.plant.hydraulic_force(s.plant)
        d1 = rate.velocity - (model.f1(x1) + model.g1() * x2)
        d2 = loop.plant.hydraulic_force(rate) - (model.f2(x1, x2) + model.g2(x2, u) * u)
        miss_1, miss_2 = estimates.d1 - d1, estimates.d2 - d2
        steady = t >= HALF * loop.simulation.duration
        return DisturbanceState(
            d1=d1,
            d2=d2,
            samples=m.samples + ops.where(steady, 1.0, 0.0),
            squares_1=m.squares_1 + ops.where(steady, d1 * d1, 0.0),
            squares_2=m.squares_2 + ops.where(steady, d2 * d2, 0.0),
            largest_1=ops.maximum(ops.absolute(d1), m.largest_1),
            largest_2=ops.maximum(ops.absolute(d2), m.largest_2),
            misses_1=m.misses_1 + ops.where(steady, miss_1 * miss_1, 0.0),
            misses_2=m.misses_2 + ops.where(steady, miss_2 * miss_2, 0.0),
        )

    def values(self, m: DisturbanceState) -> DisturbanceValues:
        return DisturbanceValues(
            self.rms(m.misses_1, m.samples),
            self.rms(m.misses_2, m.samples),
            self.rms(m.squares_1, m.samples),
            self.rms(m.squares_2, m.samples),
            m.largest_1,
            m.largest_2,
        )

    def rms(self, squares: float, samples: float) -> float:
        return math.sqrt(squares / samples) if samples > 0.0 else math.nan
