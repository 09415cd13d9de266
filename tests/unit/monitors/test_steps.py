"""Settling, overshoot and rise after steps of the demand, against analytic responses."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from hydroservo.control.monitors import RiseTime, StepResponse
from tests.support.monitors import COLUMNS, DT, Floats, instant, instants, judged, trajectories


def changes(v: dict[str, Floats]) -> tuple[NDArray[Any], Floats]:
    """The instants at which the demand jumps, and the change at each beyond that of the mean rate."""
    start = v["velocity"][0]
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"] - start))
    change = np.diff(v["demand"], prepend=start)
    rates = DT * np.stack([np.r_[v["rate"][0], v["rate"][:-1]], v["rate"]])
    rates[:, 0] = 0.0
    unexplained = np.maximum(change - rates.max(axis=0), rates.min(axis=0) - change)
    return np.flatnonzero(unexplained > band), change - rates.mean(axis=0)


@given(trajectories)
def test_settling_and_overshoot_are_those_of_numpy(trajectory: Floats) -> None:
    v = dict(zip(COLUMNS, trajectory.T, strict=True))
    rows = instants(**v)
    v["demand"][-1] = v["demand"][-2] + DT * v["rate"][-2:].mean()  # a jump at the end does not count
    band = 0.05 * np.maximum.accumulate(np.abs(v["demand"] - v["velocity"][0]))
    (jumped, change), error = changes(v), v["demand"] - v["velocity"]
    longest = largest = 0.0
    for first, end in zip([0, *jumped], [*jumped, len(error)], strict=True):
        outside = np.flatnonzero(np.abs(error[first:end]) > band[first:end])
        longest = max(longest, DT * outside[-1] if outside.size else 0.0)
    for first, end in zip(jumped, [*jumped, len(error)][1:], strict=True):
        direction = np.sign(change[first])
        largest = max(largest, np.max(-direction * error[first:end]))
    found = judged(StepResponse(), rows)
    assert found.settling_time == pytest.approx(longest, abs=1e-12)
    assert found.overshoot == pytest.approx(largest, abs=1e-9)


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
    small = np.where(time < 0.1, 0.0, np.where(time < 0.2, 0.03, 0.031))  # of which the second is 3 %
    rises = [
        judged(RiseTime(least_jump=least), instants(demand=small, velocity=small)) for least in (0.05, 0.02)
    ]
    assert [one.rise_time for one in rises] == [0.0, 0.0]
    assert math.isnan(judged(RiseTime(least_jump=1.1), instants(demand=0.03, velocity=LAG)).rise_time)


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
