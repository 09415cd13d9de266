"""Sustained oscillation against what theory and long runs say, and what is not one."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from hydroservo.control.monitors import Oscillation
from hydroservo.control.monitors.oscillation import OscillationValues

DT, T = 1e-3, 3.0
TIME = np.arange(0.0, T + 0.5 * DT, DT)


def heard(
    u: np.ndarray, demand: np.ndarray | float = 0.0, load: np.ndarray | float = 0.0
) -> OscillationValues:
    """What the monitor makes of a command, a demand that is followed, and a load."""
    monitor = Oscillation()
    loop = SimpleNamespace(simulation=SimpleNamespace(duration=T, period=DT))
    r, force = np.broadcast_to(demand, u.shape), np.broadcast_to(load, u.shape)
    m = monitor.init()
    for k, t in enumerate(TIME.tolist()):
        s = SimpleNamespace(
            controller=SimpleNamespace(u=float(u[k])),
            reference=SimpleNamespace(value=float(r[k])),
            controlled=SimpleNamespace(value=float(r[k] - 0.01 * u[k])),
            load=SimpleNamespace(force=float(force[k])),
        )
        m = monitor.step(m, loop, s, t, DT)
    return monitor.values(m)


@pytest.mark.parametrize("frequency", [4.0, 11.0, 37.0, 160.0, 333.0])
@pytest.mark.parametrize("amplitude", [0.03, 1.0, 8.0])
def test_a_tone_on_a_drift_has_its_amplitude_and_frequency(frequency: float, amplitude: float) -> None:
    values = heard(amplitude * np.sin(2.0 * math.pi * frequency * TIME + 0.3) + 0.5 * amplitude * TIME)
    assert values.oscillation_command == pytest.approx(amplitude, rel=0.1)
    assert values.oscillation_frequency == pytest.approx(frequency, rel=0.05)
    assert values.oscillation_amplitude == pytest.approx(0.01 * amplitude, rel=0.1)


def test_a_tone_beside_the_answer_to_a_demand_is_told_from_it() -> None:
    demand = np.sin(2.0 * math.pi * 1.5 * TIME)
    values = heard(3.0 * demand + 0.6 * np.sin(2.0 * math.pi * 47.3 * TIME), demand)
    assert values.oscillation_command == pytest.approx(0.6, rel=0.1)
    assert values.oscillation_frequency == pytest.approx(47.3, rel=0.05)


NOISE = np.random.default_rng(1).normal(size=TIME.size)
SINE = np.sin(2.0 * math.pi * 1.5 * TIME)
SQUARE = np.sign(np.sin(2.0 * math.pi * TIME / 0.8 + 1e-9))
RINGING = np.concatenate([np.exp(-9.0 * TIME[:400]) * np.sin(2 * math.pi * 40.0 * TIME[:400])] * 8)[
    : TIME.size
]


@pytest.mark.parametrize(
    "case",
    [
        lambda: heard(np.zeros_like(TIME)),
        lambda: heard(0.3 * NOISE),
        lambda: heard(4.0 * SINE + 0.05 * NOISE, SINE),
        lambda: heard(4.0 * SINE + 0.4 * SINE**3, SINE),
        lambda: heard(4.0 * SINE, 0.0, 1e3 * SINE),
        lambda: heard(2.0 * SQUARE + RINGING, SQUARE),
        lambda: heard(9.0 * np.exp(-3.0 * TIME) * np.sin(2.0 * math.pi * 20.0 * TIME)),
        lambda: heard(0.009 * np.sin(2.0 * math.pi * 20.0 * TIME)),
    ],
    ids=["rest", "noise", "sine", "harmonics", "load", "ringing", "decay", "small"],
)
def test_noise_answers_and_ringing_are_no_oscillation(case: object) -> None:
    assert case().oscillation_command == 0.0  # type: ignore[operator]


@pytest.mark.parametrize("amplitude", [0.015, 0.3])
def test_a_slow_motion_at_rest_cannot_be_told(amplitude: float) -> None:
    assert math.isnan(heard(amplitude * np.sin(2.0 * math.pi * 0.7 * TIME)).oscillation_command)


def test_an_oscillation_that_shrinks_to_its_limit_cycle_lasts() -> None:
    """Van der Pol's amplitude by averaging: A^2 = A1^2/(1 + (A1^2/A0^2 - 1) exp(-8 t/s))."""
    late = np.maximum(TIME - 2.0, 0.0)
    amplitude = 0.1 / np.sqrt(1.0 + (0.4**2 - 1.0) * np.exp(-8.0 * late))
    values = heard(amplitude * np.sin(2.0 * math.pi * 10.0 * TIME))
    assert values.oscillation_command == pytest.approx(0.1, rel=0.1)
    assert abs(values.oscillation_growth) < 0.03


def test_an_oscillation_that_grows_is_one() -> None:
    values = heard(0.01 * np.exp(2.0 * TIME) * np.sin(2.0 * math.pi * 20.0 * TIME))
    assert values.oscillation_growth == pytest.approx(2.0 / 20.0, rel=0.1)
    assert values.oscillation_command > 0.5
