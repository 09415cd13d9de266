"""Metrics against plain numpy formulas and analytic step responses."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import ArrayLike, NDArray

from hydroservo.controllers.pi import PI
from hydroservo.controllers.tsmc import TSMC
from hydroservo.loads.constant import Constant
from hydroservo.loop import Loop, Simulation
from hydroservo.metrics import METRIC_FIELDS, Metrics, Sample, TrackingMetrics, summary
from hydroservo.plants.load_pressure import LoadPressurePlant
from hydroservo.references.ramp import Ramp
from hydroservo.references.square import Square
from hydroservo.running import simulate
from hydroservo.signals import Demand

STROKE = 0.078
DT = 2.0**-10  # exact, as are the random trajectories, so that no comparison hangs on rounding


def measured(
    rows: Sequence[Sample], dt: float = DT, stroke: float = STROKE, lost_at: float = math.nan
) -> Metrics:
    """The metrics of samples dt apart."""
    metrics = TrackingMetrics(0.5 * (len(rows) - 1), dt)
    state = metrics.init()
    for k, row in enumerate(rows):
        state = metrics.step(state, k * dt, row)
    return summary(state, stroke, lost_at)


def sample(**given: float) -> Sample:
    """A sample; all that is not given is 0."""
    return Sample(*[0.0] * len(Sample._fields))._replace(**given)


def tracked(demand: ArrayLike, velocity: ArrayLike, rate: ArrayLike = 0.0) -> list[Sample]:
    """Samples of a demand and a velocity; all else 0."""
    columns = np.stack(np.broadcast_arrays(demand, rate, velocity), axis=1)
    names = ("demand", "demand_rate", "velocity")
    return [sample(**dict(zip(names, row, strict=True))) for row in columns.tolist()]


def samples(trajectory: NDArray[np.float64]) -> list[Sample]:
    """The rows of an array, a column for each field, as samples."""
    return [Sample(*row) for row in trajectory.tolist()]


def changes(v: dict[str, NDArray[np.float64]]) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """The samples at which the demand jumps, and the change at each beyond that of the mean rate."""
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"]))
    change = np.diff(v["demand"], prepend=0.0)
    rates = DT * np.stack([np.r_[v["demand_rate"][0], v["demand_rate"][:-1]], v["demand_rate"]])
    rates[:, 0] = 0.0
    unexplained = np.maximum(change - rates.max(axis=0), rates.min(axis=0) - change)
    return np.flatnonzero(unexplained > band), change - rates.mean(axis=0)


def errors(v: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """The error, 0 at the last sample of several if the demand jumps there."""
    error = v["velocity"] - v["demand"]
    if len(error) > 1 and len(error) - 1 in changes(v)[0]:
        error[-1] = 0.0
    return error


def rms(x: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(x**2)))


# Plain sums and extremes

numbers = st.integers(-4000, 4000).map(lambda n: 0.25 * n)
trajectories = st.integers(1, 40).flatmap(
    lambda n: arrays(np.float64, (n, len(Sample._fields)), elements=numbers)
)


@given(trajectories)
def test_sums_and_extremes_are_those_of_numpy(trajectory: NDArray[np.float64]) -> None:
    v, m = dict(zip(Sample._fields, trajectory.T, strict=True)), measured(samples(trajectory))
    error = errors(v)
    late = slice(len(trajectory) // 2, None)  # from the middle sample on, or the one after the middle
    expected = {
        "rms_error": rms(error),
        "max_error": np.max(np.abs(error)),
        "steady_rms_error": rms(error[late]),
        "steady_max_error": np.max(np.abs(error[late])),
        "control_rms": rms(v["command"]),
        "control_total_variation": np.sum(np.abs(np.diff(v["command"]))),
        "control_max": np.max(np.abs(v["command"])),
        "estimate_rms_error_1": rms((v["estimate_1"] - v["d1"])[late]),
        "estimate_rms_error_2": rms((v["estimate_2"] - v["d2"])[late]),
        "disturbance_rms_1": rms(v["d1"][late]),
        "disturbance_rms_2": rms(v["d2"][late]),
        "disturbance_max_1": np.max(np.abs(v["d1"])),
        "disturbance_max_2": np.max(np.abs(v["d2"])),
        "position_min": np.min(v["position"]),
        "position_max": np.max(v["position"]),
        "pressure_min": min(np.min(v["pressure_a"]), np.min(v["pressure_b"])),
    }
    found = {name: getattr(m, name) for name in expected}
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert m.stroke_left == bool(np.any((v["position"] < 0.0) | (v["position"] > STROKE)))


@given(trajectories)
def test_settling_and_overshoot_are_those_of_numpy(trajectory: NDArray[np.float64]) -> None:
    v, m = dict(zip(Sample._fields, trajectory.T, strict=True)), measured(samples(trajectory))
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"]))
    (jumped, change), error = changes(v), errors(v)
    longest = largest = 0.0
    for first, end in zip([0, *jumped], [*jumped, len(error)], strict=True):
        outside = np.flatnonzero(np.abs(error[first:end]) > band[first:end])
        longest = max(longest, DT * outside[-1] if outside.size else 0.0)
    for first, end in zip(jumped, [*jumped, len(error)][1:], strict=True):
        direction = np.sign(change[first])
        largest = max(largest, np.max(direction * error[first:end]))
    assert m.settling_time == pytest.approx(longest, abs=1e-12)
    assert m.overshoot == pytest.approx(largest, abs=1e-9)


def test_fields_of_metrics_are_all_declared() -> None:
    assert tuple(METRIC_FIELDS) == Metrics._fields


# Steps

time = np.arange(0.0, 2.0, DT)


def test_settling_time_of_a_first_order_step() -> None:
    tau = 0.1
    m = measured(tracked(np.full(time.size, 0.03), 0.03 * (1.0 - np.exp(-time / tau))))
    exact = tau * math.log(1.0 / 0.05)
    assert exact - DT <= m.settling_time <= exact
    assert m.overshoot == 0.0


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_settling_time_and_overshoot_of_a_second_order_step(direction: float) -> None:
    zeta, omega = 0.3, 20.0
    damped = omega * math.sqrt(1.0 - zeta**2)
    error = np.exp(-zeta * omega * time) * (
        np.cos(damped * time) + zeta * omega / damped * np.sin(damped * time)
    )
    step = 0.03 * direction
    m = measured(tracked(np.full(time.size, step), step * (1.0 - error)))
    assert m.overshoot == pytest.approx(0.03 * math.exp(-math.pi * zeta * omega / damped), rel=1e-3)
    extremes = (
        np.arange(1, 20) * math.pi / damped
    )  # |error| is 5 % for the last time after the last one above
    last = extremes[np.exp(-zeta * omega * extremes) > 0.05][-1]
    assert last < m.settling_time < last + 0.5 * math.pi / damped
    k = round(m.settling_time / DT)
    assert abs(error[k]) > 0.05
    assert (np.abs(error[k + 1 :]) <= 0.05).all()


def test_settling_time_starts_at_each_jump_and_takes_the_longest() -> None:
    demand = np.where(time < 1.0, 0.03, -0.03)
    lag = np.where(time < 1.0, np.exp(-time / 0.1), -2.0 * np.exp(-(time - 1.0) / 0.1))
    m = measured(tracked(demand, demand - 0.03 * lag))
    exact = 0.1 * math.log(2.0 / 0.05)  # the second jump is twice as high
    assert exact - DT <= m.settling_time <= exact


def test_overshoot_is_measured_in_the_direction_of_the_last_jump() -> None:
    demand = np.where(time < 1.0, 0.03, -0.03)
    error = np.where(time < 1.0, -0.002, -0.005)  # short of the first jump, beyond the second
    error[time < 0.5] = 0.001
    assert measured(tracked(demand, demand + error)).overshoot == pytest.approx(0.005)
    assert measured(tracked(demand, demand - error)).overshoot == pytest.approx(0.002)


def test_a_loop_that_never_settles_reports_all_of_the_time_since_the_jump() -> None:
    m = measured(tracked(np.full(101, 1.0), np.zeros(101)))
    assert m.settling_time == pytest.approx(100 * DT)


# What counts as a jump


def jumps(at: Callable[[float], Demand], samples: int) -> list[int]:
    """The samples of a demand that the metrics take for jumps."""
    metrics = TrackingMetrics(0.5 * (samples - 1), DT)
    state, seen = metrics.init(), []
    for k in range(samples):
        t, demand = k * DT, at(k * DT)
        before = state.jump_time if state.jump_sign else -1.0
        state = metrics.step(state, t, sample(demand=demand.value, demand_rate=demand.rate))
        if state.jump_sign and state.jump_time != before:
            seen.append(k)
    return seen


def sine(angle_per_sample: float, phase: float = 0.0) -> Callable[[float], Demand]:
    omega = angle_per_sample / DT
    return lambda t: Demand(
        0.03 * math.sin(omega * t + phase), 0.03 * omega * math.cos(omega * t + phase), 0.0
    )


def test_a_square_jumps_at_the_start_and_at_each_switch() -> None:
    assert jumps(Square(period=10 * DT).at, 21) == [0, 5, 10, 15, 20]
    assert jumps(Square(amplitude=0.001, offset=0.03, period=10 * DT).at, 12) == [0, 5, 10]


def test_a_change_within_5_percent_is_no_jump() -> None:
    assert jumps(Square(amplitude=0.0007, offset=0.03, period=10 * DT).at, 12) == [0]


def test_a_fast_sine_is_no_jump_until_too_few_samples_tell() -> None:
    for phase in np.linspace(0.0, 2.0 * np.pi, 7):
        start = [0] if math.sin(phase) else []
        assert jumps(sine(2.0 * math.pi / 9.0, phase), 500) == start  # nine samples a period
    quarter = 0.5 * math.pi
    assert len(jumps(sine(quarter, 0.5 * quarter), 500)) > 100  # four: it may as well be a square


@pytest.mark.parametrize("start", [0.0, 0.05, 0.0503])
@pytest.mark.parametrize("initial", [0.0, 0.001, -0.02])
def test_a_ramp_is_no_jump_whenever_it_starts(start: float, initial: float) -> None:
    ramp = Ramp(initial=initial, time=start)
    assert jumps(ramp.at, 500) == ([0] if initial else [])


# Flags and missing numbers


def test_estimate_errors_are_nan_without_an_observer() -> None:
    nothing = math.nan
    rows = [sample(demand=1.0, velocity=1.0, d1=2.0, d2=3.0, estimate_1=nothing, estimate_2=nothing)] * 5
    m = measured(rows)
    assert math.isnan(m.estimate_rms_error_1)
    assert math.isnan(m.estimate_rms_error_2)
    assert (m.disturbance_rms_1, m.disturbance_rms_2, m.rms_error) == (2.0, 3.0, 0.0)


def test_what_the_first_half_lacks_does_not_touch_the_second() -> None:
    lost = sample(demand=1.0, velocity=0.5, d1=2.0, d2=3.0, estimate_1=math.nan, estimate_2=math.inf)
    kept = lost._replace(estimate_1=2.5, estimate_2=2.0)
    m = measured([lost, lost, kept, kept, kept])
    assert (m.estimate_rms_error_1, m.estimate_rms_error_2) == (0.5, 1.0)


def test_second_half_metrics_are_nan_where_the_run_ended_before_it() -> None:
    metrics = TrackingMetrics(1.0, 1.0)
    state = metrics.step(metrics.init(), 0.0, sample(demand=1.0))
    m = summary(state, STROKE, 0.0)
    assert m.diverged
    assert m.diverged_at == 0.0
    assert m.rms_error == 1.0
    second_half = ("steady_rms_error", "steady_max_error", "disturbance_rms_1", "estimate_rms_error_2")
    assert all(math.isnan(getattr(m, name)) for name in second_half)


@pytest.mark.parametrize(
    ("demand", "error", "lost_at", "diverged"),
    [
        (0.03, 0.0, math.nan, False),
        (0.03, 0.0, 1.5, True),
        (0.03, 0.299, math.nan, False),
        (0.03, 0.301, math.nan, True),
        (0.03, -0.301, math.nan, True),
        (0.001, 0.077, math.nan, False),  # 77 peak demands, and yet within a stroke of 78 mm a second
        (0.001, 0.079, math.nan, True),
        (0.0, 0.077, math.nan, False),
        (0.0, 0.079, math.nan, True),
    ],
)
def test_diverged(demand: float, error: float, lost_at: float, diverged: bool) -> None:
    m = measured(tracked([demand] * 3, [demand + error] * 3), lost_at=lost_at)
    assert m.diverged is diverged
    assert m.diverged_at == pytest.approx(lost_at, nan_ok=True)


def test_what_settles_in_the_second_half_did_not_diverge() -> None:
    assert not measured(tracked(0.03, [5.0, 5.0, 0.03, 0.03, 0.03])).diverged
    assert measured(tracked(0.03, [5.0, 5.0, 5.0, 0.03, 0.03])).diverged


def test_a_jump_of_the_demand_at_the_very_end_is_nobodys_error() -> None:
    m = measured(tracked([0.03, 0.03, 0.03, -0.03], [0.03] * 4))
    assert (m.max_error, m.steady_max_error, m.rms_error, m.overshoot, m.settling_time) == (0.0,) * 5
    assert measured(tracked([0.03, 0.03, -0.03, -0.03], [0.03] * 4)).max_error == 0.06
    assert measured(tracked([0.03] * 4, [0.03, 0.03, 0.03, 0.02])).max_error == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("position", "left"), [(0.0, False), (STROKE, False), (-1e-9, True), (STROKE + 1e-9, True), (0.04, False)]
)
def test_stroke_left(position: float, left: bool) -> None:
    rows = [sample(position=p) for p in (0.039, position, 0.039)]
    m = measured(rows)
    assert m.stroke_left is left
    assert m.position_min == min(0.039, position)
    assert m.position_max == max(0.039, position)


# Through simulate

SHORT = Simulation(duration=2.0, period=1e-3, substeps=2, record_period=1e-3)


@pytest.fixture(scope="module")
def square() -> Loop:
    """30 mm/s for 2 s: 60 mm, with 39 mm to go."""
    return Loop(simulation=SHORT, reference=Square(), load=Constant(), controller=PI(5.0, 500.0))


def test_square_demand_leaves_the_stroke_from_mid_stroke(square: Loop) -> None:
    data = simulate(square, compiled=False)
    assert bool(data["stroke_left"])
    assert not bool(data["diverged"])
    assert float(data["position_max"]) == pytest.approx(0.039 + 0.060, abs=1e-3)
    assert float(data["position_max"]) == float(data["plant.position"].max())
    low = simulate(square._replace(plant=LoadPressurePlant(start_position=0.009)), compiled=False)
    assert not bool(low["stroke_left"])


def test_metrics_of_a_run_are_those_of_its_trajectory(square: Loop) -> None:
    loop = square._replace(controller=TSMC(), simulation=SHORT._replace(duration=0.1))
    data = simulate(loop, compiled=False)
    error = (data["plant.velocity"] - data["reference.value"]).values
    late = slice(50, None)
    miss = (data["controller.observer.d2"] - data["disturbance.d2"]).values[late]
    command = data["controller.u"].values
    assert float(data["rms_error"]) == pytest.approx(rms(error), rel=1e-12)
    assert float(data["steady_rms_error"]) == pytest.approx(rms(error[late]), rel=1e-12)
    assert float(data["estimate_rms_error_2"]) == pytest.approx(rms(miss), rel=1e-12)
    assert float(data["control_total_variation"]) == pytest.approx(np.abs(np.diff(command)).sum(), rel=1e-12)
    assert data["rms_error"].attrs["units"] == "m/s"


def test_a_run_that_stops_being_finite_is_a_result(square: Loop) -> None:
    wild = square._replace(
        simulation=SHORT._replace(period=1e-2, substeps=1, record_period=1e-2, duration=4.0)
    )
    data = simulate(wild, compiled=False)
    assert bool(data["diverged"])
    assert np.isnan(data["plant.velocity"].values[-1])
    assert math.isnan(float(data["steady_rms_error"]))
    assert math.isnan(float(data["estimate_rms_error_1"]))
