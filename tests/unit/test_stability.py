"""A bounded search: what it returns keeps its bounds by other means, and what stands in the way is said."""

import math
from typing import Any

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.linear.margins import margins
from hydroservo.linear.moving_margins import margin_points
from hydroservo.linear.slopes import dual_twins
from hydroservo.linear.stability import Bounds, LoopGuard
from hydroservo.runs.tuned import tuned_finding
from hydroservo.scenario.tune_table import checked_part
from tests.support.brink import at_the_brink

pytestmark = pytest.mark.slow  # it runs and draws

AXIS = "examples/axis.toml"
GAINS = ("controller.proportional_gain", "controller.integral_gain")
RIG = "rig/1khz-pi-sine"
SHORT = {"simulation.duration": "1 s", "simulation.substeps": 12}


@pytest.fixture(scope="module")
def found() -> Any:
    return hs.tune(AXIS, candidates=128, changes=SHORT)


def test_places_give_the_margins_of_a_loop_with_other_gains() -> None:
    """Against the linear model of the loop loaded with those gains."""
    loop = hs.load_scenario("cases/drift")
    changed = {"controller.proportional_gain": 0.2, "controller.integral_gain": 400.0}
    truth = margins(hs.replace(loop, changed))
    (here,) = (place for place in margin_points(loop) if place.point.command == 0.0)
    reserve = here.reserve(changed)
    assert reserve.gain_margin == pytest.approx(truth.gain_margin, rel=0.01)
    assert reserve.phase_margin == pytest.approx(truth.phase_margin, rel=0.01)
    assert reserve.sensitivity_peak == pytest.approx(truth.sensitivity_peak, rel=0.01)


def test_laws_with_other_numbers_need_no_other_twins() -> None:
    place = margin_points(hs.load_scenario("cases/drift"))[0]
    first = place.reserve({"controller.integral_gain": 400.0})
    made = set(place.twins.made)
    other = place.reserve({"controller.integral_gain": 500.0})
    assert made
    assert made == set(place.twins.made)
    assert other != first
    assert other == place._replace(twins=dual_twins()).reserve({"controller.integral_gain": 500.0})


def test_an_unstable_loop_has_no_reserve() -> None:
    place = margin_points(hs.load_scenario("cases/drift"))[0]
    reserve = place.reserve({"controller.integral_gain": 1e5})
    assert reserve.growth > 1.0
    assert math.isnan(reserve.gain_margin)


def test_the_best_keeps_its_bounds_by_bode_and_by_a_run(found: Any) -> None:
    """Bode's numbers and a run of twice the time, neither of which the search looks at."""
    loop = hs.load_scenario(AXIS, SHORT | dict(found.parameters))
    data = hs.bode(loop, measure=False)
    assert float(data["sensitivity_peak"]) <= 10.0**0.3
    assert float(data["gain_margin"]) >= 10.0**0.3
    assert float(data["phase_margin"]) >= math.pi / 6.0
    assert float(data["oscillation_gain"]) >= 10.0**0.3
    run = hs.simulate(hs.replace(loop, {"simulation.duration": 2.0}), record=())
    assert float(run["oscillation_command"]) == 0.0


def test_without_bounds_the_error_is_smaller_and_the_margins_are_gone(found: Any) -> None:
    free = hs.tune(AXIS, candidates=128, changes=SHORT, bounded=False)
    assert free.cost < 0.8 * found.cost
    data = hs.bode(hs.load_scenario(AXIS, SHORT | dict(free.parameters)), measure=False)
    assert not float(data["sensitivity_peak"]) <= 10.0**0.3  # nan where it is unstable


def test_other_bounds_are_kept_in_place_of_the_usual(found: Any) -> None:
    wide = hs.tune(AXIS, candidates=128, changes=SHORT, max_sensitivity="9 dB", phase_margin="20 deg")
    assert wide.cost < found.cost
    data = hs.bode(hs.load_scenario(AXIS, SHORT | dict(wide.parameters)), measure=False)
    assert 10.0**0.3 < float(data["sensitivity_peak"]) <= 10.0**0.45


def test_margins_before_and_after_are_those_of_bode(found: Any) -> None:
    (change,) = found.margins
    assert change.name == AXIS
    for changes, standing in ((SHORT, change.before), (SHORT | dict(found.parameters), change.after)):
        data = hs.bode(hs.load_scenario(AXIS, changes), measure=False)
        for name in ("gain_margin", "phase_margin", "sensitivity_peak", "oscillation_gain"):
            assert getattr(standing, name) == pytest.approx(float(data[name]), nan_ok=True)
    *_, table = tuned_finding(found).tables
    headings = [column.heading for column in table.columns]
    for row, standing in zip(table.rows, (change.before, change.after), strict=True):
        cells = dict(zip(headings, row, strict=True))
        assert cells["phase margin"] == (standing.phase_margin, "rad", None)
        assert cells["sensitivity peak"].value == pytest.approx(20.0 * np.log10(standing.sensitivity_peak))


def test_an_oscillation_that_no_run_can_tell_is_no_calm(found: Any) -> None:
    (change,) = found.margins
    untold = change._replace(after=change.after._replace(oscillation_command=math.nan))
    said = [f"{line.lead}{line.rest}" for line in tuned_finding(found._replace(margins=(untold,))).lead]
    assert (
        f"The run is too short to tell whether {AXIS} oscillates with these values: give it a longer run."
        in said
    )
    assert not any("too short" in f"{line.lead}{line.rest}" for line in tuned_finding(found).lead)


def test_the_front_holds_the_best_and_falls(found: Any) -> None:
    errors, activities = ([getattr(one, name) for one in found.front] for name in ("error", "activity"))
    assert errors == sorted(errors, reverse=True)
    assert activities == sorted(activities)
    assert errors[-1] <= found.best.error * (1.0 + 1e-3)


def test_what_stands_in_the_way_is_said() -> None:
    ranges = {GAINS[0]: (0.01, 0.02), GAINS[1]: (2500.0, 2600.0)}
    with pytest.raises(hs.HydroservoError) as caught:
        hs.tune(AXIS, ranges, candidates=64, changes=SHORT)
    said = str(caught.value)
    assert said.startswith("nothing found: none of 64 candidates keeps the bounds. Nearest is controller.")
    assert f"{AXIS}: sensitivity peak " in said
    assert "above 6.00 dB" in said
    assert "\n" not in said


def test_a_hunting_loop_is_beyond_the_bounds() -> None:
    """An integral against stiction and hysteresis."""
    guard = LoopGuard(Bounds(), {"loop": at_the_brink("axis/position")}, None)
    assert any("oscillates as it stands" in one for one in guard.objections({}))


def test_a_switching_law_is_bounded_by_its_oscillation_alone() -> None:
    """With its boundary layer it does not chatter; with explicit signs it does, at its own gain."""
    calm, switching = ({}, {"controller.controller.observer.realisation": {"type": "Explicit"}})
    loops = [hs.load_scenario("rig/1khz-tsmc-sine", changes) for changes in (calm, switching)]
    guards = [LoopGuard(Bounds(), {"loop": loop}, None) for loop in loops]
    assert guards[0].gains.tolist() == [1.0]
    assert guards[0].objections({}) == []
    assert guards[1].objections({})


def test_machines_of_the_uncertainty_keep_the_bounds_too() -> None:
    """The gains that the nominal machine just bears are too much for the softer one."""
    nominal = hs.load_scenario("axis/force", {"uncertainty.scale": 0})
    soft = hs.load_scenario("axis/force", {"uncertainty.scale": 1})
    gain = "controller.controller.proportional_gain"
    tried = {gain: np.geomspace(5e-4, 3e-3, 12)}
    both = [LoopGuard(Bounds(), {"loop": loop}, None).violations(tried) for loop in (nominal, soft)]
    assert 0 < np.count_nonzero(both[1] == 0.0) < np.count_nonzero(both[0] == 0.0)


@pytest.mark.parametrize(
    ("name", "value", "known"),
    [
        ("gain_margin", "6 dB", 10.0**0.3),
        ("max_sensitivity", "0.5dB", 10.0**0.025),
        ("phase_margin", "30 deg", math.pi / 6.0),
        ("gain_margin", 2.0, 2.0),
        ("bounded", False, False),
    ],
)
def test_bounds_are_read_with_their_unit(name: str, value: object, known: float) -> None:
    assert checked_part(name, value, 1, []) == pytest.approx(known)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"gain_margin": "6"}, "gain_margin = '6': must be a number with its unit, such as 6 dB"),
        ({"gain_margin": "6 m"}, "gain_margin = '6 m': must be a number with its unit, such as 6 dB"),
        ({"gain_margin": 0.5}, "gain_margin = 0.5: must be a finite number at least 1"),
        ({"phase_margin": "30 dB"}, "phase_margin = '30 dB': must be a number with its unit, such as 30 deg"),
        ({"max_sensitivity": "0 dB"}, "max_sensitivity = '0 dB': must be above 0 dB"),
        ({"bounded": 1}, "bounded = 1: must be true or false"),
    ],
)
def test_a_bound_that_is_none_is_one_line(arguments: dict[str, Any], problem: str) -> None:
    with pytest.raises(hs.HydroservoError) as caught:
        hs.tune(RIG, **arguments)
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)
