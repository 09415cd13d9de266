"""Harmonic balance against describing functions in closed form, and what is called chatter."""

import math

import numpy as np
import pytest

from hydroservo.audits.chatter import chatter_of, limit_cycles
from hydroservo.audits.describing import DescribingFunction, limited_fundamental
from hydroservo.audits.monitors import swing

LIMIT = 10.0
A, W = np.geomspace(1e-4, 14.0, 30), np.geomspace(5.0, 3000.0, 200)


def third_order(gain: float) -> np.ndarray:
    """-gain/(s (s/100 + 1)^2): phase -180 degrees and a gain of gain/200 at 100 rad/s."""
    s = 1j * W
    return -gain / (s * (s / 100.0 + 1.0) ** 2)


def of(gains: np.ndarray, swing: float = 0.0, frequency: float = 0.0) -> DescribingFunction:
    return DescribingFunction(A, W, gains, swing, frequency)


def test_a_relay() -> None:
    """4 D/(pi A) gain/200 = 1."""
    relay = 4.0 / (math.pi * A)
    (cycle,) = limit_cycles(of(np.outer(relay, third_order(10.0))))
    assert cycle.frequency == pytest.approx(100.0, rel=1e-3)
    assert cycle.amplitude == pytest.approx(4.0 / math.pi * 10.0 / 200.0, rel=1e-3)
    assert cycle.soft


@pytest.mark.parametrize(("gain", "swings"), [(150.0, False), (400.0, True)])
def test_a_limit_makes_an_unstable_loop_swing_and_leaves_a_stable_one(gain: float, swings: bool) -> None:
    answers = np.outer(A, third_order(gain))
    cut = limited_fundamental(answers.ravel(), LIMIT, np.ones(answers.size, dtype=bool)).reshape(
        answers.shape
    )
    found = chatter_of(of(cut / A[:, np.newaxis]), LIMIT, 0.0)
    assert found.chatters is swings
    if swings:  # the saturation's describing function is 200/400 at a swing of 2.474 limits at its input
        assert found.frequency == pytest.approx(100.0 / (2.0 * math.pi), rel=1e-3)
        assert found.amplitude == pytest.approx(LIMIT)
        assert found.cause == "the loop"


def test_a_relay_with_a_dead_zone_swings_only_after_a_jolt() -> None:
    zone = 0.1
    share = np.where(zone < A, np.sqrt(np.maximum(1.0 - (zone / A) ** 2, 0.0)), 0.0)
    gains = np.outer(4.0 / (math.pi * A) * share, third_order(60.0)) + 1e-9j
    (cycle,) = limit_cycles(of(gains))
    assert not cycle.soft
    found = chatter_of(of(gains), LIMIT, 0.0)
    assert not found.chatters
    assert found.after_a_jolt == pytest.approx(4.0 / math.pi * 60.0 / 200.0, rel=0.1)


def test_a_cycle_at_half_the_sampling_rate() -> None:
    gains = np.outer(0.3 / A, np.where(W[-1] == W, 1.0, -1.0)) + 0j
    (cycle,) = limit_cycles(of(gains))
    assert (cycle.frequency, cycle.amplitude) == (pytest.approx(W[-1]), pytest.approx(0.3, rel=1e-3))


def test_what_a_law_does_by_itself_is_made_larger_by_its_loop() -> None:
    gains = np.full((len(A), len(W)), 0.75 + 0j)
    gains[:, -1] = -0.1
    found = chatter_of(of(gains, swing=0.5, frequency=100.0), LIMIT, 0.0)
    assert found.cause == "the law"
    assert found.amplitude == pytest.approx(0.5 / 0.25, rel=1e-6)


def test_a_drift_is_no_swing() -> None:
    gains = np.full((len(A), len(W)), -0.5 + 0j)
    assert not chatter_of(of(gains, swing=0.5, frequency=1.0), LIMIT, 0.0).chatters


def test_the_swing_of_a_command_is_what_its_demand_does_not_ask_for() -> None:
    t = np.arange(5000) * 1e-4
    slow = 0.03 * np.sin(0.5 * math.pi * t) + 0.2
    found = swing(slow + 0.02 * np.sin(2.0 * math.pi * 330.0 * t), 1e-4)
    assert found.amplitude == pytest.approx(0.02, rel=0.01)
    assert found.frequency == pytest.approx(2.0 * math.pi * 330.0, rel=1e-2)
    assert swing(slow, 1e-4).amplitude < 1e-6
    assert math.isnan(swing([math.nan, 1.0], 1.0).amplitude)
