"""Velocity feedforward of a force loop makes the cylinder seem to stand still."""

import pytest

from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI, VelocityCompensation
from hydroservo.core.signals import Demand, Measurement
from hydroservo.papers.tsmc_eha_2021.machine import MODEL

H = 1e-3
FULL = -MODEL.f2(1.0, 0.0) / MODEL.g2(0.0, 0.0)  # 1/K_v [V s/m]


@pytest.mark.parametrize(("share", "left"), [(0.0, 1.0), (0.5, 0.5), (1.0, 0.0)])
def test_the_hydraulic_force_of_a_moved_cylinder_stays(share: float, left: float) -> None:
    """dx2/dt = f2 + g2 u, of which motion alone leaves nothing at k_v = 1/K_v."""
    law = VelocityCompensation(PI(0.0, controls=Velocity()), share * FULL)
    u = law.step(law.init(), Measurement(0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Demand(0.0, 0.0, 0.0), H).u
    rate = MODEL.f2(0.1, 0.0) + MODEL.g2(0.0, u) * u
    assert rate == pytest.approx(left * MODEL.f2(0.1, 0.0), abs=1e-6 * abs(MODEL.f2(0.1, 0.0)))
