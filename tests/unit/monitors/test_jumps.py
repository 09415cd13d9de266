"""What counts as a jump of the demand."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from hydroservo.control.monitors import StepResponse
from hydroservo.control.references import Ramp, Square
from hydroservo.core.signals import Demand
from hydroservo.testing.examples import example
from tests.support.monitors import DT, instant, loop_of


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
