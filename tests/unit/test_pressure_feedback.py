"""Dynamic pressure feedback: what damping it adds, and what stiffness it leaves."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from hydroservo.control.controlled import Position, Velocity
from hydroservo.control.controllers import PI, PressureFeedback, Saturation
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.machine.theory import damping_ratio, natural_frequency
from hydroservo.papers.tsmc_eha_2021.machine import MODEL
from tests.support.linear import Sampled

H = 1e-5
WIDE = Saturation(1e9)
REST = Demand(0.0, 0.0, 0.0)


def axis(frequency: float, damping: float) -> DesignModel:
    """A machine without friction of this frequency [Hz] and damping ratio, which its leakage gives."""
    plant, wn = MODEL.plant._replace(damping=0.0), 2.0 * math.pi * frequency
    plant = plant._replace(mass=plant.mass * (natural_frequency(plant) / wn) ** 2)
    return MODEL._replace(plant=plant._replace(leakage=plant.leakage * damping / damping_ratio(plant)))


AXIS = axis(10.3, 0.02)
OMEGA = natural_frequency(AXIS.plant)


def force_gain(added: float) -> float:
    return 2.0 * OMEGA * added / AXIS.g2(0.0, 0.0)


def law(proportional: float, damping: float, time_constant: float) -> PressureFeedback:
    inner = PI(proportional, saturation=WIDE, controls=Position())
    return PressureFeedback(inner, force_gain(damping - 0.02), time_constant, WIDE)


@pytest.mark.parametrize("added", [0.0, 0.1, 0.3, 0.58])
def test_it_adds_damping_as_static_feedback_does_on_a_static_valve(added: float) -> None:
    """g2 k_f/(2 omega_h), with a low-pass that is slow."""
    assert damping_ratio(AXIS.plant) == pytest.approx(0.02)
    found = Sampled(law(0.0, 0.02 + added, time_constant=1e3), AXIS, H).damping()
    assert found == pytest.approx(0.02 + added, abs=1e-3)  # half a period late


def test_a_steady_force_is_not_fed_back() -> None:
    feedback = law(1.0, 0.6, time_constant=0.1)
    s = feedback.init()
    for _ in range(100):
        s = feedback.step(s, Measurement(0.0, 500.0, 0.0, s.u, 0.0, 0.0, 0.0), REST, H)
        assert s.u == 0.0


def test_what_a_force_that_jumps_takes_off_decays() -> None:
    feedback = PressureFeedback(PI(0.0, controls=Velocity()), 1e-3, time_constant=0.1)
    y = [Measurement(0.0, force, 0.0, 0.0, 0.0, 0.0, 0.0) for force in (0.0, 200.0)]
    s = feedback.step(feedback.init(), y[0], REST, H)
    for _ in range(round(0.1 / H)):
        s = feedback.step(s, y[1], REST, H)
    assert s.u == pytest.approx(-0.2 * math.exp(-1.0), rel=1e-3)


# The example of dynamic pressure feedback that Moog published: a load of 10.3 Hz with a damping ratio of
# 0.02, raised to 0.6, in a position loop whose gain leaves an amplitude ratio of 1.25 at most. Mechanical
# Engineers' Handbook, vol. 2, 2006, p. 615 and table 11: -2 dB at 0.15 Hz and at 9.2 Hz.
FREQUENCIES = np.geomspace(0.05, 40.0, 2000)


def amplitudes(damping: float, rate: float) -> np.ndarray:
    """Position over demand, with a loop gain [1/s]."""
    per_velocity = -AXIS.f2(1.0, 0.0) / AXIS.g2(0.0, 0.0)  # [V s/m]
    loop = Sampled(law(rate * per_velocity, damping, time_constant=0.1), AXIS, 1e-4)
    return np.array([abs(loop.response(f)) for f in FREQUENCIES])


@pytest.mark.parametrize(("damping", "bandwidth"), [(0.02, 0.15), (0.6, 9.2)])
def test_the_bandwidth_that_the_published_example_reaches(damping: float, bandwidth: float) -> None:
    """To 20 %: here the valve has no lag; theirs, and the time constant of its network, are not published."""
    rate = brentq(
        lambda k: max(amplitudes(damping, k)) - 1.25, 0.01 * OMEGA, 1.9 * damping * OMEGA, xtol=0.01
    )
    found = amplitudes(damping, rate)
    assert FREQUENCIES[np.argmax(found < 10.0**-0.1)] == pytest.approx(bandwidth, rel=0.2)
