"""What keeps an oscillation up, against runs in which it is known, and runs that are switched by hand."""

import math

import pytest

import hydroservo as hs
from hydroservo.audits import Audit, Chatter
from hydroservo.audits.audit import Strain, strain, strain_monitors
from hydroservo.audits.facts import facts_of
from hydroservo.audits.finding import audit_lines
from hydroservo.audits.oscillation import (
    CAUSES,
    OSCILLATION,
    Remains,
    SustainedOscillation,
    sustained_oscillation,
)
from hydroservo.control.loop import Loop
from hydroservo.show import Mark
from tests.support.brink import at_the_brink

pytestmark = pytest.mark.slow  # it runs and draws

STICKING = {  # and a valve without hysteresis and overlap, so that nothing but friction is left to hunt by
    "simulation.duration": "10 s",
    "valve.hysteresis": "0 um",
    "valve.orifice.lap": "0 um",
    "plant.friction.coulomb": "1 kN",
    "plant.friction.breakaway": "1.8 kN",
    "plant.friction.bristle_stiffness": "5e7 N/m",
    "sensors.position.resolution": "1e-6 um",
    "controller": {"type": "PID", "proportional_gain": "50 V/m", "integral_gain": "1000 V/(m s)"},
}
SWITCHING = {"controller.controller.observer.realisation": {"type": "Explicit"}}
RESTS = Chatter(False, 0.0, math.nan, "nothing", 0.0, 0.01, 1.0)


def oscillation_of(loop: Loop) -> SustainedOscillation:
    _, run = facts_of(loop, ["controller.u"], [OSCILLATION])
    found = sustained_oscillation(loop, run)
    assert found is not None
    return found


def causes_of(found: SustainedOscillation) -> list[str]:
    return [one.cause for one in found.causes]


def test_a_press_hunts_by_its_hysteresis_and_integral_action() -> None:
    """Each of the two by itself ends a run from the start, as friction, steps, noise and less gain do not."""
    loop = at_the_brink("axis/force")
    found = oscillation_of(loop)
    assert (found.command, found.frequency) == (pytest.approx(0.04, rel=0.1), pytest.approx(35.0, rel=0.1))
    assert causes_of(found) == ["integral action", "valve hysteresis"]
    goes_on = ("dry friction", "converter steps", "sensor steps", "sensor noise", "sampling", "gain")
    assert [one.cause for one in found.remains if not one.ends and one.command > 0.02] == [*goes_on, "gain"]
    for path, value in (
        ("valve.hysteresis", 0.0),
        ("controller.controller.integral_gain", 0.0),
    ):
        assert float(hs.simulate(hs.replace(loop, {path: value}))["oscillation_command"]) == 0.0
    noiseless = hs.replace(loop, {"sensors.force.noise": 0.0})
    assert float(hs.simulate(noiseless)["oscillation_command"]) > 0.02


def test_a_crane_swings_by_its_gain_and_not_by_what_strikes_it() -> None:
    """Its encoder of 5 um only starts a swing that is there with one of 20 um, and not with one of 6 um."""
    loop = at_the_brink("axis/crane")
    found = oscillation_of(loop)
    assert (found.command, found.frequency) == (pytest.approx(0.56, rel=0.1), pytest.approx(8.6, rel=0.05))
    assert causes_of(found) == ["gain"]
    assert next(one for one in found.remains if one.cause == "sensor steps").command > 0.5


def test_an_axis_hunts_by_stiction_and_integral_action() -> None:
    found = oscillation_of(hs.load_scenario("axis/position", STICKING))
    assert causes_of(found) == ["integral action", "dry friction"]


def test_a_sliding_law_chatters_by_its_switching() -> None:
    found = oscillation_of(hs.load_scenario("rig/1khz-tsmc-sine", SWITCHING))
    assert causes_of(found) == ["switching"]


def test_a_linear_loop_with_ten_times_its_gain() -> None:
    loop = hs.load_scenario("rig/1khz-pi-sine", {"controller.proportional_gain": "30 V s/m"})
    found = oscillation_of(loop)
    assert [(one.cause, one.phrase) for one in found.causes] == [("gain", "at a tenth of the gain")]


def test_a_smooth_loop_names_nothing() -> None:
    found = oscillation_of(hs.load_scenario("rig/1khz-pi-sine"))
    assert (found.command, found.oscillates, found.remains) == (0.0, False, ())


def test_a_run_that_is_too_short_is_prolonged() -> None:
    """The axis hunts at 1 Hz after a disturbance at 2.2 s, of which a run of 3 s shows no cycle."""
    found = oscillation_of(at_the_brink("axis/position"))
    assert (found.longer, found.frequency) == (12.0, pytest.approx(1.0, rel=0.1))
    assert causes_of(found) == ["integral action", "valve hysteresis"]


def test_a_loop_has_the_causes_that_are_in_it() -> None:
    loop = hs.load_scenario("paper/sine-pi")
    left = {one.name for one in CAUSES if one.without(loop) is not None}
    assert left == {"integral action", "sampling", "gain"}


def test_the_run_wins_over_the_forecast() -> None:
    left = (Remains("gain", "at half the gain", 0.0, True), Remains("sampling", "faster", 0.5, False))
    swings = SustainedOscillation(1e-3, "m", 0.5, 8.0, 0.0, 0.0, left)
    run, forecast = audit_lines(Audit((), False, RESTS, "", swings))
    assert (run.lead, run.mark) == ("The run oscillates", Mark.BAD)
    assert run.rest == ", by 500 mV and 1.00 mm at 8.00 Hz to its end. It dies out at half the gain."
    assert "No chatter" not in forecast.lead
    assert "noise and steps of sensors" in forecast.rest
    both = swings._replace(remains=tuple(one._replace(ends=True) for one in left))
    assert "It needs both" in audit_lines(Audit((), False, RESTS, "", both))[0].rest
    neither = swings._replace(remains=left[1:])
    assert (
        "No single cause was found; tried were sampling."
        in audit_lines(Audit((), False, RESTS, "", neither))[0].rest
    )


def test_pressures_and_the_limit_of_the_command() -> None:
    loop = at_the_brink("axis/crane")
    _, run = facts_of(loop, ["controller.u"], strain_monitors(loop))
    found = strain(loop, run)
    assert found is not None
    assert found.pressure_max == pytest.approx(float(hs.simulate(loop)["pressure_max"]))
    assert found.pressure_max > 215e5
    assert (found.above_supply, found.limited) == (True, 0.0)
    low = audit_lines(Audit((), False, RESTS, "", None, found))[1]
    assert low.lead == "A chamber is below atmospheric pressure for 995 ms"  # but no vacuum
    bang_bang = hs.load_scenario("rig/1khz-pi-sine", {"controller.proportional_gain": "30 V s/m"})
    _, run = facts_of(bang_bang, ["controller.u"], strain_monitors(bang_bang))
    limited = strain(bang_bang, run)
    assert limited is not None
    assert limited.limited == float((abs(hs.simulate(bang_bang)["controller.u"]) >= 9.9).mean())
    assert limited.limited > 0.1
    leads = [
        one.lead
        for one in audit_lines(Audit((), False, RESTS, "", None, Strain(-1.01e5, 0.1, 300e5, 210e5, 0.2)))
    ]
    assert leads[1:] == [
        "A chamber cavitates",
        "A chamber is above the supply",
        "The command is at its limit",
    ]
