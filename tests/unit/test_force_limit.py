"""A law that moves and one that limits a force, an impedance, and the press that they close."""

import numpy as np
import pytest

from hydroservo import Loop, ParameterError, load_scenario, simulate
from hydroservo.control.controlled import Force, Position, PressureA
from hydroservo.control.controllers import PID, TSMC, FixedDemand, ForceLimit, Impedance
from hydroservo.control.wiring import wired, with_signal
from hydroservo.core.block import field_at
from hydroservo.core.signals import Demand, Measurement
from hydroservo.runs.cautions.loop import mismatch_cautions
from hydroservo.testing.examples import example

H = 1e-3
MOVE = PID(100.0, integral_gain=50.0, anti_windup=20.0, controls=Position())
PRESS = FixedDemand(PID(1e-3, integral_gain=1e-2, anti_windup=20.0, controls=Force()), 1e4)


def measured(position: float, force: float, command: float) -> Measurement:
    return Measurement(0.0, 0.0, position, command, 0.0, 0.0, force)


@pytest.mark.parametrize("force", [0.0, 8e3, 9.9e3, 12e3])
def test_the_smaller_command_is_put_out(force: float) -> None:
    """Both laws are told the command that was applied, whichever gave it."""
    law = ForceLimit(MOVE, PRESS)
    s, y, r = law.init(), measured(0.03, force, 0.5), Demand(0.05, 0.1, 0.0)
    moved = MOVE.step(s.controller, y, r, H)
    pressed = PRESS.controller.step(s.limiting.controller, y, Demand(1e4, 0.0, 0.0), H)
    found = law.step(s, y, r, H)
    assert found.u == min(moved.u, pressed.u)
    assert found.is_limiting == float(pressed.u < moved.u)
    assert (found.controller, found.limiting.controller) == (moved, pressed)


def test_each_law_is_given_its_own_signal_and_units() -> None:
    law = ForceLimit(PID(1.0), FixedDemand(PID(1.0), 60e5, PressureA()))
    with_own = with_signal(law, Position())
    assert with_own.controller.controls == Position()
    assert with_own.limiting.controller.controls == PressureA()
    assert field_at(with_own, "controller.proportional_gain").unit == "V/m"
    assert field_at(with_own, "limiting.controller.proportional_gain").unit == "V/Pa"
    assert field_at(with_own, "limiting.value").unit == "Pa"


def test_a_law_that_cannot_control_the_force_is_refused() -> None:
    law = ForceLimit(PID(1.0), FixedDemand(example(TSMC), 1e4))
    with pytest.raises(ParameterError, match=r"controller.limiting.controller.*the force"):
        wired(example(Loop, controller=law, controls=Position()))


@pytest.mark.parametrize(("value", "found"), [("500 kN", 1), ("100 kN", 0)])
def test_a_limit_out_of_reach_is_doubtful(value: str, found: int) -> None:
    loop = load_scenario("axis/press", {"controller.controller.limiting.value": value})
    lines = [line for line in mismatch_cautions(loop) if "limiting.value is 500 kN" in line]
    assert len(lines) == found


def test_ranges_of_a_base_do_not_count_for_another_signal() -> None:
    law = {"proportional_gain": "0.1 V/bar", "integral_gain": "0.1 V/(bar s)", "integral_range": "2 bar"}
    changes = {
        "controller.controller.limiting": {"controls": {"type": "PressureA"}, "value": "70 bar"},
        "controller.controller.limiting.controller": law | {"derivative_gain": "0 V s/bar"},
    }
    loop = load_scenario("axis/press", changes)
    assert field_at(loop, "controller.controller.limiting.controller.proportional_gain").unit == "V/Pa"


def test_an_impedance_yields_as_its_equation_has_it() -> None:
    """M z'' + B z' + K z = F - F_0, from rest under a constant excess of force."""
    mass, damping, stiffness, excess = 50.0, 4e3, 1e5, 2e3
    law = Impedance(MOVE, force=1e4, mass=mass, damping=damping, stiffness=stiffness)
    s, step = law.init(), 1e-6
    for _ in range(20_000):
        s = law.step(s, measured(0.03, 1e4 + excess, 0.0), Demand(0.05, 0.0, 0.0), step)
    roots = np.roots([mass, damping, stiffness])
    shares = np.linalg.solve([[1.0, 1.0], roots], [-1.0, 0.0])
    z = excess / stiffness * (1.0 + np.real(shares @ np.exp(roots * 0.02)))
    assert s.deflection == pytest.approx(z, rel=1e-3)


def test_an_impedance_does_not_push_back() -> None:
    law = Impedance(MOVE, force=1e4, damping=1e3, mass=10.0)
    y, r = measured(0.03, 0.0, 0.2), Demand(0.05, 0.1, 0.0)
    s = law.step(law.init(), y, r, H)
    assert (s.deflection, s.deflection_rate) == (0.0, 0.0)
    assert s.controller == MOVE.step(MOVE.init(), y, r, H)


def test_an_impedance_without_stiffness_holds_its_force_and_gives_way_once() -> None:
    """Against a spring that its demand presses: F = k (r - z), until F is F_0; and z ends at 0, not below."""
    law, spring, reach = Impedance(MOVE, force=1e4, mass=0.0, damping=1e5), 1e6, 0.02
    s = law.init()
    for _ in range(2_000):
        s = law.step(s, measured(0.03, spring * (reach - s.deflection), 0.0), Demand(0.05, 0.0, 0.0), H)
    assert s.deflection == pytest.approx(reach - 1e4 / spring)
    for _ in range(2_000):
        s = law.step(s, measured(0.03, 0.0, 0.0), Demand(0.05, 0.0, 0.0), H)
        assert s.deflection >= 0.0
    assert (s.deflection, s.deflection_rate) == (0.0, 0.0)


@pytest.mark.parametrize("stiffness", [1e6, 1e7, 1e8])
def test_the_press_holds_its_force_and_opens_again(stiffness: float) -> None:
    changes = {"plant.mechanism.stiffness": stiffness, "uncertainty.scale": 0}
    loop = load_scenario("axis/press", changes)
    run = simulate(loop, record=("plant.position", "controller.controller.is_limiting"))
    assert float(run["contact_overshoot"]) < 0.05
    assert float(run["holding_time"]) < 1.0
    assert float(run["bounces"]) == 0.0
    assert float(run["plant.position"][-1]) == pytest.approx(0.05, abs=1e-3)
    limits = run["controller.controller.is_limiting"].values
    assert limits[:500].mean() < 0.1
    assert limits[1200:2000].mean() > 0.9
    assert limits[-500:].mean() < 0.1
