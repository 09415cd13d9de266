"""Metrics of a run, accumulated sample by sample, so that memory does not grow with its length."""

import math
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.field import Field, declared_fields

__all__ = [
    "FLAGS",
    "LOST",
    "LOST_ERROR",
    "METRIC_FIELDS",
    "SMALLER_IS_BETTER",
    "Metrics",
    "MetricsState",
    "Sample",
    "TrackingMetrics",
    "lost_error",
    "summary",
]

SETTLING_BAND = 0.05  # of the largest demand so far
LOST = 10.0  # peak demands that the error of a run that diverged exceeds
CROSSING = 1.0  # [s] in which that error would carry the piston across its stroke
LOST_ERROR = f"both {LOST:g} peak demands and one stroke a second"  # in words


class Sample(NamedTuple):
    """What metrics are computed from."""

    demand: Annotated[float, Field("m/s", "velocity demand")]
    demand_rate: Annotated[float, Field("m/s^2", "its rate")]
    velocity: Annotated[float, Field("m/s", "piston velocity")]
    position: Annotated[float, Field("m", "piston position")]
    command: Annotated[float, Field("V", "command")]
    pressure_a: Annotated[float, Field("Pa", "pressure in chamber A; nan for a plant without chambers")]
    pressure_b: Annotated[float, Field("Pa", "pressure in chamber B; nan for a plant without chambers")]
    d1: Annotated[float, Field("m/s^2", "lumped disturbance d_L1")]
    d2: Annotated[float, Field("N/s", "lumped disturbance d_L2")]
    estimate_1: Annotated[float, Field("m/s^2", "its estimate; nan without an observer")]
    estimate_2: Annotated[float, Field("N/s", "its estimate; nan without an observer")]


class MetricsState(NamedTuple):
    """Running sums; the second-half ones start at half the duration."""

    samples: float
    samples_steady: float
    error_squares: float
    error_squares_steady: float
    error_max: float
    error_max_steady: float
    command_squares: float
    command_max: float
    command_variation: float
    last_command: float
    last_demand: float
    last_rate: float
    demand_max: float
    jump_time: float
    jump_sign: float
    settling: float
    overshoot: float
    d1_squares: float
    d2_squares: float
    d1_max: float
    d2_max: float
    miss1_squares: float
    miss2_squares: float
    low: float
    high: float
    pressure_low: float


class TrackingMetrics(NamedTuple):
    """Accumulates the metrics of one run.

    A jump of the demand is a change between two samples, beyond what its rates at both explain, of more than
    5 % of the largest demand so far; the start from rest counts, a kink does not. ``settling_time`` is the
    longest time from a jump (or the start) until the error is last outside a band of 5 % of the largest
    demand so far. ``overshoot`` is the largest error in the direction of the demand's last jump; 0 for a
    demand without jumps. A demand that jumps at the last sample asks for what no time is left for: that
    sample's error counts as 0.
    """

    half: float  # number of the sample from which on a run counts as steady
    period: float  # [s]

    def init(self) -> MetricsState:
        zeros = dict.fromkeys(MetricsState._fields, 0.0)
        return MetricsState(**zeros | {"low": math.inf, "high": -math.inf, "pressure_low": math.inf})

    def step(self, s: MetricsState, t: float, v: Sample) -> MetricsState:
        steady = s.samples >= self.half
        demand_max = ops.maximum(s.demand_max, ops.absolute(v.demand))
        band = SETTLING_BAND * demand_max
        dt = ops.where(s.samples > 0.0, self.period, 0.0)
        jump = v.demand - s.last_demand - 0.5 * dt * (s.last_rate + v.demand_rate)
        kink = 0.5 * dt * ops.absolute(v.demand_rate - s.last_rate)
        jumped = ops.absolute(jump) - kink > band
        too_late = jumped and s.samples > 0.0 and s.samples >= 2.0 * self.half
        error = ops.where(too_late, 0.0, v.velocity - v.demand)
        size = ops.absolute(error)
        jump_time = ops.where(jumped, t, s.jump_time)
        jump_sign = ops.where(jumped, ops.sign(jump), s.jump_sign)
        outside = ops.where(size > band, t - jump_time, 0.0)
        change = ops.where(s.samples > 0.0, ops.absolute(v.command - s.last_command), 0.0)
        miss1, miss2 = v.estimate_1 - v.d1, v.estimate_2 - v.d2
        return MetricsState(
            samples=s.samples + 1.0,
            samples_steady=s.samples_steady + ops.where(steady, 1.0, 0.0),
            error_squares=s.error_squares + error * error,
            error_squares_steady=s.error_squares_steady + ops.where(steady, error * error, 0.0),
            error_max=ops.maximum(size, s.error_max),
            error_max_steady=ops.maximum(ops.where(steady, size, 0.0), s.error_max_steady),
            command_squares=s.command_squares + v.command * v.command,
            command_max=ops.maximum(ops.absolute(v.command), s.command_max),
            command_variation=s.command_variation + change,
            last_command=v.command,
            last_demand=v.demand,
            last_rate=v.demand_rate,
            demand_max=demand_max,
            jump_time=jump_time,
            jump_sign=jump_sign,
            settling=ops.maximum(outside, s.settling),
            overshoot=ops.maximum(jump_sign * error, s.overshoot),
            d1_squares=s.d1_squares + ops.where(steady, v.d1 * v.d1, 0.0),
            d2_squares=s.d2_squares + ops.where(steady, v.d2 * v.d2, 0.0),
            d1_max=ops.maximum(ops.absolute(v.d1), s.d1_max),
            d2_max=ops.maximum(ops.absolute(v.d2), s.d2_max),
            miss1_squares=s.miss1_squares + ops.where(steady, miss1 * miss1, 0.0),
            miss2_squares=s.miss2_squares + ops.where(steady, miss2 * miss2, 0.0),
            low=ops.minimum(v.position, s.low),
            high=ops.maximum(v.position, s.high),
            pressure_low=ops.minimum(v.pressure_a, ops.minimum(v.pressure_b, s.pressure_low)),
        )


class Metrics(NamedTuple):
    """What a run is judged by."""

    rms_error: Annotated[float, Field("m/s", "rms of the velocity error")]
    max_error: Annotated[float, Field("m/s", "largest velocity error")]
    steady_rms_error: Annotated[float, Field("m/s", "rms of the velocity error, second half")]
    steady_max_error: Annotated[float, Field("m/s", "largest velocity error, second half")]
    settling_time: Annotated[
        float, Field("s", "longest time from a jump until within 5 % of the peak demand")
    ]
    overshoot: Annotated[float, Field("m/s", "largest error in the direction of the last jump")]
    control_rms: Annotated[float, Field("V", "rms of the command")]
    control_total_variation: Annotated[float, Field("V", "sum of the command's changes")]
    control_max: Annotated[float, Field("V", "largest command")]
    estimate_rms_error_1: Annotated[float, Field("m/s^2", "rms error of the estimate of d_L1, second half")]
    estimate_rms_error_2: Annotated[float, Field("N/s", "rms error of the estimate of d_L2, second half")]
    disturbance_rms_1: Annotated[float, Field("m/s^2", "rms of d_L1, second half")]
    disturbance_rms_2: Annotated[float, Field("N/s", "rms of d_L2, second half")]
    disturbance_max_1: Annotated[float, Field("m/s^2", "largest |d_L1|")]
    disturbance_max_2: Annotated[float, Field("N/s", "largest |d_L2|")]
    position_min: Annotated[float, Field("m", "lowest piston position")]
    position_max: Annotated[float, Field("m", "highest piston position")]
    pressure_min: Annotated[
        float, Field("Pa", "lowest gauge pressure in a chamber; nan for a plant without chambers")
    ]
    stroke_left: Annotated[bool, Field("", "the piston left its stroke")]
    diverged: Annotated[
        bool,
        Field(
            "",
            f"a state stopped being finite, or the second half's error passed {LOST_ERROR}",
        ),
    ]
    diverged_at: Annotated[float, Field("s", "sample at which a state stopped being finite; nan if none did")]


METRIC_FIELDS = declared_fields(Metrics)
FLAGS = ("stroke_left", "diverged")  # the metrics that are true or false
SMALLER_IS_BETTER = (
    "rms_error",
    "max_error",
    "steady_rms_error",
    "steady_max_error",
    "settling_time",
    "overshoot",
    "control_rms",
    "control_total_variation",
    "control_max",
    "estimate_rms_error_1",
    "estimate_rms_error_2",
)


def lost_error(demand_max: float, stroke: float) -> float:
    """The error beyond which a run has diverged [m/s], from its largest demand [m/s] and the stroke [m]."""
    return max(LOST * demand_max, stroke / CROSSING)


def summary(s: MetricsState, stroke: float, lost_at: float) -> Metrics:
    """The metrics of a run from its running sums; nan where the run ended before there were any.

    Args:
        s: the running sums.
        stroke: of the plant [m].
        lost_at: instant of the sample in which a state stopped being finite [s]; nan if none did.
    """

    def rms(squares: float, count: float) -> float:
        return math.sqrt(squares / count) if count > 0 else math.nan

    return Metrics(
        rms_error=rms(s.error_squares, s.samples),
        max_error=s.error_max,
        steady_rms_error=rms(s.error_squares_steady, s.samples_steady),
        steady_max_error=s.error_max_steady if s.samples_steady > 0 else math.nan,
        settling_time=s.settling,
        overshoot=s.overshoot,
        control_rms=rms(s.command_squares, s.samples),
        control_total_variation=s.command_variation,
        control_max=s.command_max,
        estimate_rms_error_1=rms(s.miss1_squares, s.samples_steady),
        estimate_rms_error_2=rms(s.miss2_squares, s.samples_steady),
        disturbance_rms_1=rms(s.d1_squares, s.samples_steady),
        disturbance_rms_2=rms(s.d2_squares, s.samples_steady),
        disturbance_max_1=s.d1_max,
        disturbance_max_2=s.d2_max,
        position_min=s.low,
        position_max=s.high,
        pressure_min=s.pressure_low if math.isfinite(s.pressure_low) else math.nan,
        stroke_left=s.low < 0.0 or s.high > stroke,
        diverged=not math.isnan(lost_at) or s.error_max_steady > lost_error(s.demand_max, stroke),
        diverged_at=lost_at,
    )
