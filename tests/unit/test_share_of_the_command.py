"""What adds to a law's command, or multiplies it, tells the law its own share of what was applied."""

from typing import Any

import pytest

from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import (
    PI,
    AccelerationFeedback,
    DeadBandCompensation,
    DeadBandJump,
    DirectionalGain,
    FlowCompensation,
    PressureFeedback,
    Saturation,
    VelocityCompensation,
)
from hydroservo.core.signals import Demand, Measurement

H = 1e-3
LIMIT = Saturation(5.0)
LAW = PI(0.5, 30.0, anti_windup=100.0, saturation=Saturation(1e3), controls=Velocity())
WRAPPED = [
    AccelerationFeedback(LAW, 0.01, saturation=LIMIT),
    DeadBandCompensation(LAW, 0.5, 0.4, 0.05, LIMIT),
    DeadBandJump(LAW, 0.5, 0.4, 0.05, LIMIT),
    DirectionalGain(LAW, 0.8, 1.4, LIMIT),
    FlowCompensation(LAW, 120e5, 3e-3, 1.5e-3, 35e5, 1e5, 0.01, LIMIT),
    PressureFeedback(LAW, 1e-3, 0.02, LIMIT),
    VelocityCompensation(LAW, 2.0, LIMIT),
]


def measured(k: int, command: float) -> Measurement:
    return Measurement(0.1 + 0.01 * k, 300.0 * (-1.0) ** k, 0.0, command, 40e5 + 1e5 * k, 60e5, 0.0)


@pytest.mark.parametrize("law", WRAPPED, ids=lambda law: type(law).__name__)
def test_where_nothing_limits_the_law_runs_as_if_it_were_alone(law: Any) -> None:
    s, alone = law.init(), LAW.init()
    for k in range(20):
        r = Demand(0.6 * (-1.0) ** (k // 6), 0.0, 0.0)
        s, alone = law.step(s, measured(k, s.u), r, H), LAW.step(alone, measured(k, alone.u), r, H)
        assert k == 0 or s.u != s.controller.u
        assert abs(s.u) < 5.0
        assert s.controller == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("law", WRAPPED, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("demand", [30.0, -30.0])
def test_where_the_command_is_limited_the_law_does_not_wind_up(law: Any, demand: float) -> None:
    s = law.init()
    for _ in range(300):
        s = law.step(s, measured(0, s.u), Demand(demand, 0.0, 0.0), H)
    assert s.u == (5.0 if demand > 0.0 else -5.0)
    assert abs(s.controller.u) < 5.0 / 0.5 + 30.0 * 31.0 / 100.0
