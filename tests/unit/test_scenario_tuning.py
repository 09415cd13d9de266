"""``hs.tune`` of scenarios by name: what it makes of them and of its arguments, and what it refuses."""

from pathlib import Path
from typing import Any

import pytest

import hydroservo as hs
from hydroservo.linear.first_guess import first_guess
from hydroservo.runs.tuned import tuned_finding
from hydroservo.scenario import assemble
from hydroservo.scenario.ranges import as_entries
from hydroservo.scenario.tuning import as_toml, comments_of
from hydroservo.scenario.tuning_task import task_of_scenarios
from tests.support.equality import assert_same_block

GAIN = "controller.proportional_gain"
RIG = "rig/1khz-pi-square"


def test_a_task_is_what_the_table_of_the_first_scenario_says() -> None:
    task, search = task_of_scenarios([RIG], {}, {}, {}, ()), assemble(RIG).search
    assert RIG in task.scenarios
    assert list(task.scenarios) == list(search.scenarios)
    assert list(task.names) == [f"{name}, scale {x:g}" for name in search.scenarios for x in search.scales]
    assert list(task.aim.weights) == [weight for weight in search.weights for _ in search.scales]
    assert task.ranges == {path: (one.low, one.high) for path, one in search.ranges.items()}
    assert (task.candidates, task.seed, task.aim.seeds) == (search.candidates, search.seed, search.seeds)
    changes = [{"uncertainty.scale": scale} for scale in search.scales]
    first = search.scenarios[0]
    for loop, change in zip(task.aim.loops, changes, strict=False):  # those of the first scenario
        assert_same_block(loop, hs.load_scenario(first, change))
    assert len(task.aim.loops) == len(task.names)


def test_what_is_said_takes_the_place_of_parts_of_the_table() -> None:
    ranges = as_entries({GAIN: (1.0, 2.0)})
    task = task_of_scenarios([RIG], ranges, {"candidates": 64, "scales": [0], "seeds": 2}, {}, ())
    assert task.ranges == {GAIN: (1.0, 2.0)}
    assert (task.candidates, task.aim.seeds, len(task.aim.loops)) == (64, 2, len(task.scenarios))
    alone = task_of_scenarios([RIG, RIG], ranges, {}, {}, ())
    assert (alone.scenarios, set(alone.aim.weights)) == ([RIG, RIG], {1.0})


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"weights": [1]}, "weights = [1]: must be a number above 0 for each scenario; there are 2"),
        ({"weights": 1}, "weights = 1: must be a number above 0 for each scenario; there are 2"),
        ({"scales": [1, 1]}, "scales = [1, 1]: must be different numbers"),
        ({"metric": "rms"}, "metric = 'rms': must be one of rms_error, "),
        ({"metric": 1}, "metric = 1: must be the name of a metric"),
        ({"seeds": 0}, "seeds = 0: must be a whole number from 1 to 10000"),
        ({"effort": -1}, "effort = -1: must be a finite number, at least 0"),
        ({"candidates": 1.5}, "candidates = 1.5: must be a whole number from 0 to 10000000"),
        ({"seed": "1"}, "seed = '1': must be a whole number from 0 to 9223372036854775807"),
        ({"ranges": {GAIN: "2..1"}}, f"ranges: {GAIN}: '2' is more than '1', its upper end"),
        ({"ranges": {GAIN: 3}}, f"ranges: {GAIN}: 3 must be a range"),
        ({"ranges": {"plant.mass": (1, 2)}}, "ranges: plant.mass: must be in the controller or sensors"),
        ({"changes": {"tune.seeds": 0}}, f"{RIG}, overridden: tune.seeds: 0 must be a whole number"),
        ({"aim": "rig/1khz-pi-squar"}, "did you mean rig/1khz-pi-square?"),
        ({"aim": "paper/sine-pi"}, "ranges = '{}': must name a number, or the scenario have [tune.vary]"),
        ({"aim": []}, "aim = []: must be an Aim, such as Aim([loop]), or scenarios by name or path"),
        ({"aim": hs.load_scenario("paper/sine-pi")}, "aim = a Loop: must be an Aim, such as Aim([loop])"),
    ],
)
def test_what_is_wrong_is_one_line(arguments: dict[str, Any], problem: str) -> None:
    with pytest.raises(hs.HydroservoError) as caught:
        hs.tune(**{"aim": RIG} | arguments)
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"metric": "max_error"}, "metric = 'max_error': is for scenarios by name; an Aim has its own"),
        ({"effort": 0.0}, "effort = 0.0: is for scenarios by name"),
        ({"changes": {}}, "changes = {}: is for scenarios by name"),
        ({"ranges": {GAIN: "1..2"}}, f"{GAIN} = '1..2': must be two numbers in SI units for an Aim"),
        ({"ranges": {GAIN: hs.relative(-0.5, 1.0)}}, "must be two numbers in SI units for an Aim"),
        ({"ranges": None}, "ranges = '{}': must name at least one parameter"),
        ({"candidates": 0}, "candidates = 0: is a first guess without a search; leave out the ranges"),
    ],
)
def test_an_aim_is_all_that_is_said_of_loops(arguments: dict[str, Any], problem: str) -> None:
    aim = hs.Aim([hs.load_scenario("paper/sine-pi")])
    with pytest.raises(hs.ParameterError) as caught:
        hs.tune(**{"aim": aim, "ranges": {GAIN: (1.0, 2.0)}} | arguments)
    assert problem in str(caught.value)


@pytest.mark.slow  # some ten seconds
def test_loops_that_no_scenario_names_are_counted() -> None:
    loop = hs.load_scenario("paper/sine-pi", {"simulation.duration": "20 ms", "simulation.substeps": 4})
    assert hs.tune(hs.Aim([loop]), {GAIN: (1.0, 10.0)}, candidates=64).names == ["loop 1"]


@pytest.mark.slow  # some ten seconds
def test_loops_that_are_left_unstable_are_named() -> None:
    short = {"simulation.duration": "20 ms"}
    found = hs.tune(RIG, {GAIN: (50.0, 100.0)}, scales=[0.0], candidates=64, changes=short)
    names = ["rig/1khz-pi-sine, scale 0", "rig/1khz-pi-square, scale 0"]
    assert found.unstable == names
    assert f"unstable for small motions: {'; '.join(names)}" in repr(found)
    assert f"<b>Unstable for small motions</b>: {'; '.join(names)}." in found._repr_html_()


@pytest.mark.slow  # some ten seconds
def test_an_interrupted_search_says_so_where_its_values_stand() -> None:
    loop = hs.load_scenario("paper/sine-pi", {"simulation.duration": "20 ms", "simulation.substeps": 4})
    found = hs.tune(hs.Aim([loop], seeds=2), {GAIN: (1.0, 10.0)}, candidates=64)._replace(interrupted=True)
    said = "The search was interrupted after 64 candidates"
    finding = tuned_finding(found)
    assert f"{said}; these are the best values so far." in map(str, finding.lead)
    assert finding.numbers["interrupted"]
    assert f"{said}." in comments_of(found)


def test_values_are_tables_that_build_on_a_scenario(tmp_path: Path) -> None:
    values = {GAIN: 2.5, "controller.integral_gain": 30.0}
    tables = as_toml(values, "first\nsecond")
    (tmp_path / "tuned.toml").write_text(f'base = "{RIG}"\n{tables}')
    assert_same_block(hs.load_scenario(tmp_path / "tuned.toml"), hs.load_scenario(RIG, values))


@pytest.mark.slow  # it runs the loops, and judges their margins
def test_without_candidates_the_values_are_a_first_guess() -> None:
    short = {"simulation.duration": "1 s", "uncertainty.scale": 0.0}
    found = hs.tune("axis/pump-controlled", candidates=0, scales=[0.0], changes=short)
    guess = first_guess(hs.load_scenario("axis/pump-controlled", short))
    assert guess is not None
    assert found.parameters == pytest.approx(guess.parameters, rel=1e-4)
    assert list(found.rule.rules) == list(found.parameters)
    assert found.guess == found.best
    assert repr(found).endswith("a first guess, without a search")
    beyond = "The first guess is beyond the bounds."
    assert any(line.lead == beyond for line in found.finding().lead) is not found.best.within
    loop = hs.load_scenario("axis/pump-controlled", short | dict(found.parameters))
    assert found.after == pytest.approx([float(hs.simulate(loop)["rms_error"])], rel=1e-6)
    assert (found.runs, found.edges, found.front) == (0, [], ())
    gains = found.finding().tables[0]
    assert [one.heading for one in gains.columns] == ["parameter", "before", "first guess", "unit", "rule"]
    assert "Merritt" in str(gains.rows[0][-1].value)


@pytest.mark.parametrize(
    ("scenario", "arguments", "problem"),
    [
        ("axis/force", {}, "candidates = 0: is a first guess without a search, and there is none here"),
        ("paper/sine-tsmc", {}, "there is none here: it is for a PI, a PID or a Cascade"),
        (
            RIG,
            {"ranges": {GAIN: (1.0, 10.0)}},
            "candidates = 0: is a first guess without a search; leave out",
        ),
    ],
)
def test_where_there_is_no_first_guess_is_one_line(
    scenario: str, arguments: dict[str, Any], problem: str
) -> None:
    changes = {"simulation.duration": "20 ms"}
    with pytest.raises(hs.ParameterError) as caught:
        hs.tune(scenario, candidates=0, bounded=False, changes=changes, **arguments)
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)
