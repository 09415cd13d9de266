"""Acceleration feedback: what damping it adds, and to what."""

import pytest

from hydroservo.control.controlled import Position, Velocity
from hydroservo.control.controllers import PI, AccelerationFeedback, Saturation
from hydroservo.control.observers import FilteredDerivative
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.theory import damping_ratio, natural_frequency
from hydroservo.papers.tsmc_eha_2021.machine import MODEL
from tests.support.linear import Sampled

H = 1e-6
PLANT = MODEL.plant._replace(damping=0.0)
AXIS = MODEL._replace(plant=PLANT)
VELOCITY_GAIN = -AXIS.g2(0.0, 0.0) / AXIS.f2(1.0, 0.0)  # [m/(s V)]


@pytest.mark.parametrize("added", [0.0, 0.1, 0.5])
def test_it_adds_damping_on_a_static_valve(added: float) -> None:
    """K_v k_a omega_h/2, with a low-pass that is fast."""
    gain = 2.0 * added / (VELOCITY_GAIN * natural_frequency(PLANT))
    law = AccelerationFeedback(
        PI(0.0, controls=Position()), gain, FilteredDerivative(0.0), saturation=Saturation(1e9)
    )
    assert Sampled(law, AXIS, H).damping() == pytest.approx(damping_ratio(PLANT) + added, abs=2e-3)


def test_a_steady_acceleration_takes_its_share_off() -> None:
    law = AccelerationFeedback(PI(0.0, controls=Velocity()), 0.02, FilteredDerivative(1e-3))
    s = law.init()
    for k in range(100):
        s = law.step(
            s, Measurement(5.0 * k * 1e-3, 0.0, 0.0, s.u, 0.0, 0.0, 0.0), Demand(0.0, 0.0, 0.0), 1e-3
        )
    assert s.u == pytest.approx(-0.02 * 5.0)
