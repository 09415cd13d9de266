"""Monitors against plain numpy formulas, analytic responses, and each other in every way of running."""

import math
import pickle
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import ArrayLike, NDArray

from hydroservo import (
    Loop,
    LoopError,
    ParameterError,
    Simulation,
    monitors,
    replace,
    simulate,
    simulate_batch,
)
from hydroservo.block import Block, Field
from hydroservo.controllers import PI, TSMC
from hydroservo.holds import DelayedHold
from hydroservo.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.loads import Constant, Sine
from hydroservo.metrics import METRIC_FIELDS, declared_metrics, monitors_of, usual
from hydroservo.monitors import (
    ChamberPressures,
    CommandEffort,
    CommandEnergy,
    Disturbance,
    Energy,
    IntegralCriteria,
    PistonTravel,
    RiseTime,
    StepResponse,
    TrackingError,
)
from hydroservo.monitors.group import group, named
from hydroservo.plants import Cylinder, LoadPressurePlant
from hydroservo.references import Ramp, Square
from hydroservo.roles import Monitor, role
from hydroservo.runs.run import ready
from hydroservo.scenario import load_plugin
from hydroservo.signals import Demand
from hydroservo.testing.examples import example

Floats = NDArray[np.float64]

unpickled = pickle.loads  # of what is pickled here
STROKE = 0.078
DT = 2.0**-10  # exact, as are the random trajectories, so that no comparison hangs on rounding


def instant(**given: float) -> Any:
    """A state of a loop at an instant; all that is not given is 0."""
    known = dict.fromkeys(("velocity", "position", "pressure_a", "pressure_b", "demand", "rate", "u"), 0.0)
    known |= given
    plant = SimpleNamespace(**{name: known[name] for name in tuple(known)[:4]})
    return SimpleNamespace(
        plant=plant,
        reference=Demand(known["demand"], known["rate"], 0.0),
        controller=SimpleNamespace(u=known["u"]),
    )


def loop_of(duration: float) -> Any:
    """What monitors ask of a loop whose command acts at once."""
    return SimpleNamespace(
        simulation=SimpleNamespace(duration=duration),
        plant=SimpleNamespace(stroke=STROKE),
        held=lambda s: s.controller.u,
        hold=SimpleNamespace(at=lambda held, _: held),
    )


def judged(monitor: Block, rows: Sequence[Any], dt: float = DT) -> Any:
    """What a monitor makes of instants dt apart, of which the last is the end."""
    last = len(rows) - 1
    m, loop = monitor.init(), loop_of(last * dt)
    for k, row in enumerate(rows):
        m = monitor.step(m, loop, row, k * dt, dt if k < last else 0.0)
    return monitor.values(m)


def instants(**columns: ArrayLike) -> list[Any]:
    """A row for each element of the columns."""
    table = np.stack(np.broadcast_arrays(*columns.values()), axis=1)
    return [instant(**dict(zip(columns, row, strict=True))) for row in table.tolist()]


def rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


def changes(v: dict[str, Floats]) -> tuple[NDArray[Any], Floats]:
    """The instants at which the demand jumps, and the change at each beyond that of the mean rate."""
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"]))
    change = np.diff(v["demand"], prepend=0.0)
    rates = DT * np.stack([np.r_[v["rate"][0], v["rate"][:-1]], v["rate"]])
    rates[:, 0] = 0.0
    unexplained = np.maximum(change - rates.max(axis=0), rates.min(axis=0) - change)
    return np.flatnonzero(unexplained > band), change - rates.mean(axis=0)


# Plain sums and extremes

COLUMNS = ("demand", "rate", "velocity", "u", "position", "pressure_a", "pressure_b")
numbers = st.integers(-4000, 4000).map(lambda n: 0.25 * n)
trajectories = st.integers(2, 40).flatmap(lambda n: arrays(np.float64, (n, len(COLUMNS)), elements=numbers))


@given(trajectories)
def test_sums_and_extremes_are_those_of_numpy(trajectory: Floats) -> None:
    """The last instant is the end: no time is left for its error."""
    v = dict(zip(COLUMNS, trajectory.T, strict=True))
    rows, error = instants(**v), (v["velocity"] - v["demand"])[:-1]
    late = slice(len(error) // 2 + len(error) % 2, None)  # from half the duration on
    steady = error[late] if error[late].size else np.array([math.nan])
    low = np.minimum(v["pressure_a"], v["pressure_b"])
    expected: list[tuple[Block, tuple[Any, ...]]] = [
        (TrackingError(), (rms(error), np.max(np.abs(error)), rms(steady), np.max(np.abs(steady)))),
        (CommandEffort(), (rms(v["u"]), np.sum(np.abs(np.diff(v["u"]))), np.max(np.abs(v["u"])))),
        (
            CommandEnergy(500.0),
            (
                DT * np.sum(v["u"][:-1] ** 2),
                np.mean(np.abs(v["u"][:-1]) >= 500.0),
            ),
        ),
        (
            PistonTravel(),
            (
                np.min(v["position"]),
                np.max(v["position"]),
                bool(np.any((v["position"] < 0.0) | (v["position"] > STROKE))),
            ),
        ),
        (
            ChamberPressures(100.0),
            (
                np.min(low),
                max(np.max(v["pressure_a"]), np.max(v["pressure_b"])),
                DT * np.sum(low[:-1] < 100.0),
            ),
        ),
        (
            IntegralCriteria(),
            (
                DT * np.sum(np.abs(error)),
                DT * np.sum(error**2),
                DT**2 * np.sum(np.arange(error.size) * np.abs(error)),
            ),
        ),
    ]
    for monitor, values in expected:
        found = tuple(judged(monitor, rows))
        assert found == pytest.approx(values, rel=1e-12, abs=1e-12, nan_ok=True), monitor


@given(trajectories)
def test_settling_and_overshoot_are_those_of_numpy(trajectory: Floats) -> None:
    v = dict(zip(COLUMNS, trajectory.T, strict=True))
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"]))
    (jumped, change), error = changes(v), v["velocity"] - v["demand"]
    longest = largest = 0.0
    for first, end in zip([0, *jumped], [*jumped, len(error)], strict=True):
        outside = np.flatnonzero(np.abs(error[first:end]) > band[first:end])
        longest = max(longest, DT * outside[-1] if outside.size else 0.0)
    for first, end in zip(jumped, [*jumped, len(error)][1:], strict=True):
        direction = np.sign(change[first])
        largest = max(largest, np.max(direction * error[first:end]))
    found = judged(StepResponse(), instants(**v))
    assert found.settling_time == pytest.approx(longest, abs=1e-12)
    assert found.overshoot == pytest.approx(largest, abs=1e-9)


@pytest.mark.parametrize("steps", [[0.25, 0.5, 0.125, 0.125], [0.125, 0.125, 0.5, 0.25]])
def test_steps_of_any_length_weigh_as_long_as_they_are(steps: list[float]) -> None:
    """The second half begins at 0.5 s, with whole steps."""
    sizes, t, loop = [3.0, -1.0, 2.0, 4.0], 0.0, loop_of(1.0)
    tracking, integral = TrackingError(), IntegralCriteria()
    m, n = tracking.init(), integral.init()
    for size, dt in zip([*sizes, 9.0], [*steps, 0.0], strict=True):
        row = instant(velocity=size)
        m, n, t = tracking.step(m, loop, row, t, dt), integral.step(n, loop, row, t, dt), t + dt
    starts = np.cumsum([0.0, *steps[:-1]])
    squares, late = np.square(sizes) * steps, starts >= 0.5
    found = tracking.values(m)
    assert found.rms_error == pytest.approx(math.sqrt(squares.sum()))
    assert found.max_error == 4.0
    assert found.steady_rms_error == pytest.approx(
        math.sqrt(squares[late].sum() / np.array(steps)[late].sum())
    )
    assert found.steady_max_error == np.abs(sizes)[late].max()
    assert integral.values(n).iae == pytest.approx(np.abs(sizes) @ steps)
    assert integral.values(n).itae == pytest.approx((starts * np.abs(sizes)) @ steps)


# Steps

time = np.arange(0.0, 2.0, DT)
TAU = 0.1
LAG = 0.03 * (1.0 - np.exp(-time / TAU))  # the velocity after a step of the demand to 0.03


def test_settling_time_of_a_first_order_step() -> None:
    found = judged(StepResponse(), instants(demand=0.03, velocity=LAG))
    exact = TAU * math.log(1.0 / 0.05)
    assert exact - DT <= found.settling_time <= exact
    assert found.overshoot == 0.0
    wide = judged(StepResponse(0.2), instants(demand=0.03, velocity=LAG)).settling_time
    assert TAU * math.log(5.0) - DT <= wide <= TAU * math.log(5.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_rise_time_of_a_first_order_step(direction: float) -> None:
    found = judged(RiseTime(), instants(demand=direction * 0.03, velocity=direction * LAG))
    assert found.rise_time == pytest.approx(math.log(9.0) * TAU, abs=DT)
    half = judged(RiseTime(0.0, 0.5), instants(demand=direction * 0.03, velocity=direction * LAG))
    assert half.rise_time == pytest.approx(math.log(2.0) * TAU, abs=DT)


def test_rise_time_is_the_longest_and_starts_from_the_velocity_at_the_jump() -> None:
    slow = np.where(time < 1.0, LAG, 0.0)
    tail = np.exp(-(time - 1.0) / (2.0 * TAU))
    velocity = np.where(time < 1.0, slow, 0.01 + (slow[time < 1.0][-1] - 0.01) * tail)
    demand = np.where(time < 1.0, 0.03, 0.01)
    found = judged(RiseTime(), instants(demand=demand, velocity=velocity))
    assert found.rise_time == pytest.approx(2.0 * math.log(9.0) * TAU, abs=2 * DT)
    first = judged(RiseTime(), instants(demand=demand, velocity=velocity)[: time.size // 2])
    assert first.rise_time == pytest.approx(math.log(9.0) * TAU, abs=DT)


def test_a_rise_that_is_cut_off_is_infinite_and_no_jump_has_none() -> None:
    square = np.where(time < 0.1, 0.03, -0.03)
    never = instants(demand=0.03, velocity=0.5 * LAG)
    cut = instants(demand=square, velocity=np.where(time < 0.1, LAG, -0.03))
    assert judged(RiseTime(), never).rise_time == judged(RiseTime(), cut).rise_time == math.inf
    assert math.isnan(judged(RiseTime(), instants(demand=0.0, velocity=LAG)).rise_time)
    ramp = instants(demand=time, rate=1.0, velocity=time)
    assert math.isnan(judged(RiseTime(), ramp).rise_time)
    assert math.isnan(judged(RiseTime(least_jump=0.04), instants(demand=0.03, velocity=LAG)).rise_time)


def test_a_jump_at_the_very_end_asks_for_no_rise() -> None:
    rows = instants(demand=0.03, velocity=LAG)
    assert judged(RiseTime(), [*rows, instant(demand=-0.03, velocity=0.03)]) == judged(RiseTime(), rows)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_settling_time_and_overshoot_of_a_second_order_step(direction: float) -> None:
    zeta, omega = 0.3, 20.0
    damped = omega * math.sqrt(1.0 - zeta**2)
    error = np.exp(-zeta * omega * time) * (
        np.cos(damped * time) + zeta * omega / damped * np.sin(damped * time)
    )
    step = 0.03 * direction
    found = judged(StepResponse(), instants(demand=step, velocity=step * (1.0 - error)))
    assert found.overshoot == pytest.approx(0.03 * math.exp(-math.pi * zeta * omega / damped), rel=1e-3)
    extremes = np.arange(1, 20) * math.pi / damped
    last = extremes[np.exp(-zeta * omega * extremes) > 0.05][-1]  # the last extreme outside the band
    assert last < found.settling_time < last + 0.5 * math.pi / damped
    k = round(found.settling_time / DT)
    assert abs(error[k]) > 0.05
    assert (np.abs(error[k + 1 :]) <= 0.05).all()


def test_settling_time_starts_at_each_jump_and_takes_the_longest() -> None:
    demand = np.where(time < 1.0, 0.03, -0.03)
    lag = np.where(time < 1.0, np.exp(-time / TAU), -2.0 * np.exp(-(time - 1.0) / TAU))
    found = judged(StepResponse(), instants(demand=demand, velocity=demand - 0.03 * lag))
    exact = TAU * math.log(2.0 / 0.05)  # the second jump is twice as high
    assert exact - DT <= found.settling_time <= exact


def test_overshoot_is_measured_in_the_direction_of_the_last_jump() -> None:
    demand = np.where(time < 1.0, 0.03, -0.03)
    error = np.where(time < 1.0, -0.002, -0.005)  # short of the first jump, beyond the second
    error[time < 0.5] = 0.001
    beyond = [judged(StepResponse(), instants(demand=demand, velocity=demand + e)) for e in (error, -error)]
    assert [found.overshoot for found in beyond] == pytest.approx([0.005, 0.002])


def test_a_loop_that_never_settles_reports_all_of_the_time_since_the_jump() -> None:
    found = judged(StepResponse(), instants(demand=np.full(101, 1.0)))
    assert found.settling_time == pytest.approx(100 * DT)


def test_integral_criteria_of_an_exponential() -> None:
    """The left rule is too large by half a step of the first value, and ITAE starts from 0."""
    h, tau = 2.0**-14, 0.05
    t = h * np.arange(2**13 + 1)
    found = judged(IntegralCriteria(), instants(velocity=0.03 * np.exp(-t / tau)), h)
    left = math.exp(-t[-1] / tau)
    assert found.iae == pytest.approx(0.03 * tau * (1.0 - left) + 0.5 * h * 0.03, rel=1e-5)
    assert found.ise == pytest.approx(0.03**2 * 0.5 * tau * (1.0 - left**2) + 0.5 * h * 0.03**2, rel=1e-5)
    assert found.itae == pytest.approx(0.03 * tau**2 * (1.0 - (1.0 + t[-1] / tau) * left), rel=1e-5)


def test_command_energy_and_share_at_the_limit_of_a_clipped_sine() -> None:
    h = 2.0**-14
    t = h * np.arange(2**14 + 1)
    command = np.clip(2.0 * np.sin(2.0 * math.pi * t), -1.0, 1.0)
    found = judged(CommandEnergy(limit=1.0), instants(u=command), h)
    assert found.saturation_share == pytest.approx(2.0 / 3.0, abs=4 * h)
    free = 2.0 * (1.0 / 6.0 - math.sin(math.pi / 3.0) / (2.0 * math.pi))  # of 4 sin^2 over 4 times 1/12
    assert found.control_energy == pytest.approx(2.0 / 3.0 + 2.0 * free, abs=4 * h)


# What counts as a jump


def jumps(at: Callable[[float], Demand], samples: int) -> list[int]:
    """The instants of a demand that are taken for jumps."""
    monitor, loop = StepResponse(), loop_of((samples - 1) * DT)
    m, seen = monitor.init(), []
    for k in range(samples):
        t, demand = k * DT, at(k * DT)
        before = m.jump_time if m.jump_sign else -1.0
        m = monitor.step(m, loop, instant(demand=demand.value, rate=demand.rate), t, DT)
        if m.jump_sign and m.jump_time != before:
            seen.append(k)
    return seen


def sine(angle_per_sample: float, phase: float = 0.0) -> Callable[[float], Demand]:
    omega = angle_per_sample / DT
    return lambda t: Demand(
        0.03 * math.sin(omega * t + phase), 0.03 * omega * math.cos(omega * t + phase), 0.0
    )


def test_a_square_jumps_at_the_start_and_at_each_switch() -> None:
    assert jumps(example(Square, period=10 * DT).at, 21) == [0, 5, 10, 15, 20]
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
    ramp = example(Ramp, initial=initial, time=start)
    assert jumps(ramp.at, 500) == ([0] if initial else [])


# Flags and missing numbers


def test_a_jump_of_the_demand_at_the_very_end_is_nobodys_error() -> None:
    rows = instants(demand=[0.03, 0.03, 0.03, -0.03], velocity=0.03)
    assert tuple(judged(TrackingError(), rows)) == (0.0, 0.0, 0.0, 0.0)
    assert tuple(judged(StepResponse(), rows)) == (0.0, 0.0)
    earlier = judged(TrackingError(), instants(demand=[0.03, 0.03, -0.03, -0.03], velocity=0.03))
    assert earlier.max_error == earlier.steady_max_error == 0.06


@pytest.mark.parametrize(
    ("position", "left"), [(0.0, False), (STROKE, False), (-1e-9, True), (STROKE + 1e-9, True), (0.04, False)]
)
@pytest.mark.parametrize("place", [1, 2])
def test_stroke_left(position: float, left: bool, place: int) -> None:
    positions = [0.039, 0.039, 0.039]
    positions[place] = position
    found = judged(PistonTravel(), instants(position=positions))
    assert found == (min(0.039, position), max(0.039, position), left)


def test_what_the_run_did_not_come_to_is_nan() -> None:
    monitor = TrackingError()
    m = monitor.step(monitor.init(), loop_of(1.0), instant(demand=1.0), 0.0, 0.25)
    found = monitor.values(m)
    assert found.rms_error == 1.0
    assert math.isnan(found.steady_rms_error)
    assert math.isnan(found.steady_max_error)
    for one, unknown in [
        (TrackingError(), {"rms_error", "max_error", "steady_rms_error", "steady_max_error"}),
        (CommandEffort(), {"control_rms"}),
        (CommandEnergy(), {"saturation_share"}),
        (PistonTravel(), {"position_min", "position_max"}),
        (ChamberPressures(), {"pressure_min", "pressure_max"}),
        (RiseTime(), {"rise_time"}),
        (
            Disturbance(),
            {f"{what}_{i}" for what in ("estimate_rms_error", "disturbance_rms") for i in (1, 2)},
        ),
    ]:
        values = one.values(one.init())._asdict()
        assert {name for name, value in values.items() if math.isnan(value)} == unknown


# Names


def test_each_metric_of_hydroservo_has_a_name_of_its_own() -> None:
    own = [one.values(one.init())._fields for one in (getattr(monitors, name)() for name in monitors.__all__)]
    assert list(METRIC_FIELDS) == [name for names in own for name in names] + ["diverged", "diverged_at"]
    assert all(field.meaning for field in METRIC_FIELDS.values())


def test_monitors_are_called_after_their_classes() -> None:
    found = named([ChamberPressures(), StepResponse(), StepResponse(0.01), ChamberPressures(1e5)])
    assert list(found) == ["chamber_pressures", "step_response", "step_response_2", "chamber_pressures_2"]
    assert named({"mine": RiseTime()}) == {"mine": RiseTime()}
    assert named(()) == {}


def test_a_metric_that_another_gives_already_has_its_monitors_name_before_it() -> None:
    watching = {"loose": StepResponse(0.2), "tight": StepResponse(0.01), "rise": RiseTime()}
    assert list(declared_metrics(watching)) == [
        *("settling_time", "overshoot", "tight_settling_time", "tight_overshoot", "rise_time"),
        *("diverged", "diverged_at"),
    ]


@pytest.mark.parametrize(
    ("metrics", "problem"),
    [
        (StepResponse(), "metrics = StepResponse(band=0.05): must be a list of monitors"),
        ("rise", "metrics = 'rise': must be a list of monitors"),
        ([StepResponse], "must be a monitor: a block with init, step and values"),
        ([example(PI)], "must be a monitor: a block with init, step and values"),
        (
            {"rise time": RiseTime()},
            "metrics = 'rise time': must be a name of letters, digits and underscores",
        ),
        ({"_rise": RiseTime()}, "metrics = '_rise': must be a name of letters, digits and underscores"),
        ([RiseTime(low=2.0)], "low = 2"),
    ],
)
def test_what_is_no_monitor_is_refused(metrics: Any, problem: str) -> None:
    with pytest.raises(ParameterError) as caught:
        simulate(SHORT, metrics=metrics)
    assert problem in str(caught.value)


def test_a_group_is_a_block_that_pickles() -> None:
    made = group({"first": StepResponse(0.01), "second": Energy()})
    assert made.first.band == 0.01
    assert type(made) is type(group({"first": Energy(), "second": Energy()}))
    loop = example(Loop, metrics=made)
    assert unpickled(pickle.dumps(loop)) == loop
    assert type(unpickled(pickle.dumps(made))) is type(made)
    assert replace(loop, {"metrics.first.band": 0.5}).metrics.first == StepResponse(0.5)


def test_the_usual_monitors_are_those_that_the_loop_has_signals_for() -> None:
    always = ["tracking_error", "step_response", "command_effort", "piston_travel"]
    assert list(usual(example(Loop))) == always
    assert list(usual(example(Loop, plant=example(Cylinder)))) == [*always, "chamber_pressures"]
    assert sorted(usual(example(Loop, controller=example(TSMC)))) == sorted([*always, "disturbance"])
    assert monitors_of(example(Loop, metrics=group({"energy": Energy()}))) == {"energy": Energy()}


# Through simulate

SHORT = example(
    Loop,
    Simulation(duration=0.1, period=1e-3, substeps=2, record_period=1e-3),
    reference=example(Square),
    load=example(Constant),
    controller=PI(5.0, 500.0),
)
FULL = example(
    Loop,
    Simulation(duration=2e-3, period=1e-4, substeps=4, record_period=1e-4),
    plant=example(Cylinder),
    reference=Square(amplitude=3e-3, period=2e-3),
    load=Sine(50.0, 300.0),
    controller=example(TSMC),
)
EVERY = [getattr(monitors, name)() for name in monitors.__all__]


def test_square_demand_leaves_the_stroke_from_mid_stroke() -> None:
    """30 mm/s for 2 s: 60 mm, with 39 mm to go."""
    square = replace(SHORT, {"simulation.duration": 2.0})
    data = simulate(square, compiled=False)
    assert bool(data["stroke_left"])
    assert not bool(data["diverged"])
    assert float(data["position_max"]) == pytest.approx(0.039 + 0.060, abs=1e-3)
    assert float(data["position_max"]) == pytest.approx(float(data["plant.position"].max()), rel=1e-4)
    low = simulate(square._replace(plant=example(LoadPressurePlant, start_position=0.009)), compiled=False)
    assert not bool(low["stroke_left"])


def test_metrics_of_a_run_are_those_of_its_trajectory() -> None:
    """With one step a sample the trajectory has all that the monitors hear."""
    loop = replace(SHORT._replace(controller=example(TSMC)), {"simulation.substeps": 1})
    data = simulate(loop, compiled=False)
    error = (data["plant.velocity"] - data["reference.value"]).values[:-1]
    late = slice(50, None)
    miss = (data["controller.observer.d2"] - data["disturbance.d2"]).values[late]
    command = data["controller.u"].values
    assert float(data["rms_error"]) == pytest.approx(rms(error), rel=1e-12)
    assert float(data["steady_rms_error"]) == pytest.approx(rms(error[late]), rel=1e-12)
    assert float(data["estimate_rms_error_2"]) == pytest.approx(rms(miss), rel=1e-12)
    assert float(data["disturbance_max_1"]) == np.abs(data["disturbance.d1"].values).max()
    assert float(data["control_total_variation"]) == pytest.approx(np.abs(np.diff(command)).sum(), rel=1e-12)
    assert data["rms_error"].attrs == {
        **{"units": "m/s", "long_name": "rms of the velocity error", "kind": "metric", "better": "smaller"}
    }
    assert data["position_min"].attrs["worst"] == "least"


def test_the_disturbance_of_a_law_that_knows_its_machine_is_the_load() -> None:
    loop = SHORT._replace(controller=example(TSMC), load=Constant(120.0))
    data = simulate(loop, compiled=False)
    mass = ready(loop).controller.model.plant.mass
    assert data["disturbance.d1"].values == pytest.approx(np.full(101, -120.0 / mass))
    assert float(data["disturbance_rms_1"]) == pytest.approx(120.0 / mass)
    heavier = replace(ready(loop), {"controller.model.plant.mass": 2.0 * mass})
    assert float(simulate(heavier, compiled=False)["disturbance_max_1"]) > 10.0 * 120.0 / mass


def test_a_run_that_stops_being_finite_is_a_result() -> None:
    wild = SHORT._replace(simulation=Simulation(duration=4.0, period=1e-2, record_period=1e-2))
    with pytest.warns(match="steps"):
        data = simulate(wild, compiled=False)
    assert bool(data["diverged"])
    assert np.isnan(data["plant.velocity"].values[-1])
    assert math.isnan(float(data["steady_rms_error"]))
    assert math.isfinite(float(data["rms_error"]))


def test_energies_of_a_cylinder_balance() -> None:
    """What the supply gives and the valve does not lose moves the piston, squeezes the oil, and leaks."""
    dt = 2.5e-6
    loop = FULL._replace(
        simulation=Simulation(0.02, dt, 1, dt),
        plant=example(Cylinder, internal_leakage=2.5e-12),
        load=Constant(1000.0),
        reference=example(Square, period=1.0),
        controller=PI(2.0, 200.0),
    )
    data = simulate(loop, metrics=[Energy()])
    v, x, a, b = (
        data[f"plant.{name}"].values for name in ("velocity", "position", "pressure_a", "pressure_b")
    )
    plant, oil = ready(loop).plant, ready(loop).plant.oil.bulk_modulus(0.0)
    volume_a = plant.dead_volume_a + plant.area_a * x
    volume_b = plant.dead_volume_b + plant.area_b * (plant.stroke - x)
    moved = np.trapezoid((plant.area_a * a - plant.area_b * b) * v, dx=dt)
    squeezed = np.trapezoid(volume_a * a / oil, a) + np.trapezoid(volume_b * b / oil, b)
    leaked = np.trapezoid(plant.internal_leakage * (a - b) ** 2, dx=dt)
    used = float(data["supply_energy"] - data["valve_loss"])
    assert float(data["valve_loss"]) > 0.0
    assert used == pytest.approx(moved + squeezed + leaked, rel=1e-3)
    assert moved > 0.5 * used

    line, start = loop.supply.pressures(loop.supply.init()), ready(loop).plant.init()
    openings = loop.valve.gain * data["controller.u"].values
    drawn = [
        loop.plant.flows(start._replace(pressure_a=p, pressure_b=q), loop.valve.orifice, opening, line).supply
        for p, q, opening in zip(a[:-1], b[:-1], openings[:-1], strict=True)
    ]
    assert float(data["supply_energy"]) == pytest.approx(line.supply * dt * sum(drawn), rel=1e-9)


def test_the_command_counts_as_it_acts_at_the_valve() -> None:
    """A command that comes half a period late is the one before for the first of two steps."""
    loop = SHORT._replace(hold=DelayedHold(5e-4))
    data = simulate(loop, metrics=[CommandEnergy(0.1)], compiled=False)
    u = data["controller.u"].values
    acting = np.stack([np.r_[0.0, u[:-2]], u[:-1]], axis=1)
    assert float(data["control_energy"]) == pytest.approx(5e-4 * np.sum(acting**2), rel=1e-12)
    assert float(data["saturation_share"]) == pytest.approx(np.mean(np.abs(acting) >= 0.1), rel=1e-12)


class Nothing(NamedTuple):
    """A state of no numbers."""


HEARD: list[tuple[float, float, float, float]] = []


class Listener(NamedTuple):
    """Keeps the instants, velocities and demands that it hears, and how long each step is."""

    def init(self) -> Nothing:
        return Nothing()

    def step(self, m: Nothing, loop: Block, s: Any, t: float, dt: float) -> Nothing:
        HEARD.append((t, s.plant.velocity, s.reference.value, dt))
        return m

    def values(self, m: Nothing) -> Nothing:
        return m


@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_ripple_between_samples_counts(integrator: Block) -> None:
    """A load that swings once a sample period: at the samples there is little to see of it."""
    loop = example(
        Loop,
        Simulation(duration=0.2, period=1e-2, substeps=64, record_period=1e-2, integrator=integrator),
        plant=example(LoadPressurePlant, damping=5000.0),
        load=Sine(1000.0, 100.0),
        reference=example(Ramp, time=9.0),
        controller=PI(0.001, 0.0),
    )
    HEARD.clear()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Rosenbrock's steps
        data = simulate(loop, metrics=[TrackingError(), Listener()], compiled=False)
    end = next(i for i, row in enumerate(HEARD) if row[3] == 0.0)
    t, v, demand, dt = np.array(HEARD[1 : end + 1]).T  # the first tried whether the monitor fits
    error = v - demand
    assert t == pytest.approx(np.r_[0.0, np.cumsum(dt)[:-1]], abs=1e-12)
    assert t[-1] == pytest.approx(0.2)
    assert t.size > 8 * 20
    assert float(data["rms_error"]) == pytest.approx(math.sqrt(np.sum(error**2 * dt) / 0.2), rel=1e-12)
    assert float(data["max_error"]) == np.abs(error[:-1]).max()
    late = t >= 0.1 - 1e-9
    steady = math.sqrt(np.sum((error**2 * dt)[late]) / 0.1)
    assert float(data["steady_rms_error"]) == pytest.approx(steady, rel=1e-9)
    sampled = (data["plant.velocity"] - data["reference.value"]).values[10:-1]
    assert float(data["steady_max_error"]) > 5.0 * np.abs(sampled).max()
    assert steady > 5.0 * rms(sampled)


# The same bits in every way of running


@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_to_hear_of_the_steps_changes_none(integrator: Block) -> None:
    loop = replace(FULL, {"simulation.integrator": integrator})
    with_all, with_none = (simulate(loop, metrics=one, compiled=False) for one in (EVERY, ()))
    assert set(with_none.data_vars) - set(with_all.data_vars) == set()
    for name in with_none.data_vars:
        assert with_none[name].identical(with_all[name]), name


@pytest.mark.slow
@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_each_way_of_running_gives_the_same_bits(integrator: Block) -> None:
    loop = replace(FULL, {"simulation.integrator": integrator})
    interpreted = simulate(loop, metrics=EVERY, compiled=False)
    compiled = simulate(loop, metrics=EVERY, strict=True)
    assert compiled.identical(interpreted)
    assert not bool(compiled["diverged"])
    masses = np.array([5.0, loop.plant.mechanism.mass, 9.0])
    table = simulate_batch(loop, {"plant.mechanism.mass": masses}, metrics=EVERY, strict=True)
    for name in METRIC_FIELDS:
        assert table[name].values[1].tobytes() == interpreted[name].values.tobytes(), name


# A user's own

OWN = '''\
from typing import Annotated, NamedTuple

from hydroservo import Field, ops
from hydroservo.roles import Monitor, role


class Crossings(NamedTuple):
    count: Annotated[float, Field("", "zero crossings so far")]
    last: float


class Counted(NamedTuple):
    zero_crossings: Annotated[float, Field("", "zero crossings of the error", smaller_is_better=True)]


@role(Monitor)
class ZeroCrossings(NamedTuple):
    """How often the velocity error changes its sign."""

    def init(self):
        return Crossings(0.0, 0.0)

    def step(self, m, loop, s, t, dt):
        error = s.plant.velocity - s.reference.value
        return Crossings(m.count + ops.where(error * m.last < 0.0, 1.0, 0.0), error)

    def values(self, m):
        return Counted(m.count)
'''


@pytest.mark.parametrize("compiled", [False, True])
def test_a_users_own_monitor(tmp_path: Path, compiled: bool) -> None:
    path = tmp_path / "my_metric.py"
    path.write_text(OWN, encoding="utf-8")
    own = next(cls for cls in load_plugin(path) if cls.__name__ == "ZeroCrossings")
    loop = replace(SHORT, {"simulation.substeps": 1, "reference.period": 0.02})
    data = simulate(loop, metrics={"crossings": own()}, compiled=compiled)
    error = (data["plant.velocity"] - data["reference.value"]).values
    expected = np.sum(error[1:] * error[:-1] < 0.0)
    assert expected > 2
    assert float(data["zero_crossings"]) == expected
    heard = np.r_[0.0, 0.0, np.cumsum(error[1:] * error[:-1] < 0.0)[:-1]]  # before each sample
    assert data["crossings.count"].values.tolist() == heard.tolist()
    assert data["zero_crossings"].attrs["better"] == "smaller"
    assert "rms_error" not in data


class Two(NamedTuple):
    first: Annotated[float, Field("m", "the first")]
    second: Any = 0.0


def wrong(after: Any = Two(1.0), result: Any = Two(1.0)) -> Block:  # noqa: B008
    """A monitor that does not do what it should."""

    @role(Monitor)
    class Wrong(NamedTuple):
        def init(self) -> Two:
            return Two(0.0)

        def step(self, m: Any, loop: Block, s: Block, t: float, dt: float) -> Any:
            return after

        def values(self, m: Any) -> Any:
            return result

    return Wrong()


@pytest.mark.parametrize(
    ("monitor", "problem"),
    [
        (ChamberPressures(), r"the metric mine \(ChamberPressures\) does not fit this loop: .*pressure_a"),
        (Disturbance(), r"the metric mine \(Disturbance\) does not fit this loop"),
        (wrong(after=Demand(0.0, 0.0, 0.0)), "the metric mine: a step must return a state of init's type"),
        (wrong(after=Two(1.0, 2)), "the metric mine: a step must return a state of init's type, with floats"),
        (wrong(result=Two(1.0, "many")), "the metric mine: values must be a NamedTuple of floats and flags"),
        (wrong(result=2.0), "the metric mine: values must be a NamedTuple of floats and flags"),
    ],
)
def test_a_monitor_that_does_not_fit_is_said_in_one_line(monitor: Block, problem: str) -> None:
    with pytest.raises(LoopError, match=problem) as caught:
        simulate(SHORT, metrics={"mine": monitor})
    assert "\n" not in str(caught.value)


def test_a_batch_has_the_metrics_that_are_asked_for() -> None:
    table = simulate_batch(SHORT, {"plant.mass": [5.0, 6.0]}, metrics=[RiseTime(), StepResponse()])
    assert isinstance(table, xr.Dataset)
    found = [str(name) for name, one in table.data_vars.items() if one.attrs.get("kind") == "metric"]
    assert found == ["rise_time", "settling_time", "overshoot", "diverged", "diverged_at"]
