"""Sums, extremes and shares, against plain numpy; and what the run did not come to."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from hydroservo.control.monitors import (
    ChamberPressures,
    CommandEffort,
    CommandEnergy,
    Disturbance,
    IntegralCriteria,
    PistonTravel,
    RiseTime,
    StepResponse,
    SupplyLine,
    TrackingError,
)
from hydroservo.core.block import Block
from tests.support.monitors import (
    COLUMNS,
    DT,
    STROKE,
    Floats,
    instant,
    instants,
    judged,
    loop_of,
    rms,
    trajectories,
)


@given(trajectories)
def test_sums_and_extremes_are_those_of_numpy(trajectory: Floats) -> None:
    """The last instant is the end: no time is left for its error."""
    v = dict(zip(COLUMNS, trajectory.T, strict=True))
    rows, error = instants(**v, supply=v["u"]), (v["velocity"] - v["demand"])[:-1]
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
        (SupplyLine(), (np.min(v["u"]), np.max(v["u"]), v["u"][0] - np.min(v["u"]))),
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


def test_a_jump_of_the_demand_at_the_very_end_is_nobodys_error() -> None:
    rows = instants(demand=[0.03, 0.03, 0.03, -0.03], velocity=0.03)
    assert tuple(judged(TrackingError(), rows)) == (0.0, 0.0, 0.0, 0.0)
    assert tuple(judged(StepResponse(), rows)) == (0.0, 0.0, 0.0, False)
    small = instants(demand=[0.03, 0.03, 0.03, 0.029], velocity=[0.0, 0.031, 0.031, 0.031])
    assert tuple(judged(StepResponse(), small))[:2] == (
        0.0,
        pytest.approx(0.001),
    )  # within the band of 0.0015
    back = instants(demand=[0.03, 0.0, 0.0, 0.01], velocity=[0.0, 0.03, 0.03, 0.03])
    assert tuple(judged(StepResponse(), back))[:2] == (pytest.approx(2.0 * DT), 0.0)
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
