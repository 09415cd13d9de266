"""``hydroservo tune`` with the search of a scenario, [tune], and the same from Python."""

import json
import shlex

import pytest

import hydroservo
from hydroservo.scenario import load_scenario
from tests.support.commands.runner import PLUGIN, failed, succeeded
from tests.support.commands.tuning import GAIN
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.nightly  # tests.regression runs each command

SEARCH = """\
base = "paper/sine-pi"
[simulation]
duration = "50 ms"
period = "1 ms"
substeps = 4
[valve]
type = "FirstOrderValve"
time_constant = "10 ms"
[tune]
scenarios = ["my.toml", "square.toml"]
weights = [1, 2.5]
scales = [-1, 1]
seeds = 2
seed = 2
candidates = 64
[tune.vary]
controller.proportional_gain = "0.3..30 V s/m"
controller.integral_gain = "1..100 V/m"
"""
SQUARE = 'base = "my.toml"\nreference.type = "Square"\nreference.period = "4 s"\nload.type = "Constant"\n'


@pytest.fixture
def search(tmp_path, monkeypatch):
    """Two scenarios that are tuned together, the second built on the first."""
    (tmp_path / "my.toml").write_text(SEARCH)
    (tmp_path / "square.toml").write_text(SQUARE)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("search")
def test_the_search_of_a_scenario_is_that_of_the_options():
    """Whichever of the scenarios is named."""
    said = json.loads(succeeded("tune", "my.toml", "--json"))
    vary = ("--vary", f"{GAIN}=0.3..30 V s/m", "--vary", "controller.integral_gain=1..100 V/m")
    options = ("--weights", "1,2.5", "--scales=-1,1", "--seeds", "2", "--seed", "2", "--candidates", "64")
    bare = ("--set", "tune.seeds=1", "--set", "tune.candidates=4096")
    full = json.loads(succeeded("tune", "my.toml", "square.toml", *bare, *vary, *options, "--json"))
    other = json.loads(succeeded("tune", "square.toml", "--json"))
    assert shlex.split(said.pop("command")) == ["hydroservo", "tune", "my.toml"]
    for one in (full, other):
        assert one.pop("command")
        assert one == said
    assert [row["scenario"] for row in said["scenarios"]] == [
        f"{name}, scale {scale}" for name in ("my.toml", "square.toml") for scale in (-1, 1)
    ]
    assert said["runs"] == 64 * 2 * 4


@pytest.mark.usefixtures("search")
def test_options_override_the_search_of_a_scenario():
    said = json.loads(
        succeeded("tune", "my.toml", "--vary", f"{GAIN}=1..2", "--scales=1", "--seeds", "1", "--json")
    )
    assert list(said["parameters"]) == [GAIN]
    assert [row["weight"] for row in said["scenarios"]] == [1.0, 2.5]
    assert said["runs"] == 64 * 2
    alone = ("--set", 'tune.scenarios=["my.toml"]', "--weights", "1")
    assert "there are 1" in failed("tune", "my.toml", *alone[:2])  # the two weights of the file
    said = json.loads(succeeded("tune", "my.toml", "--set", "tune.weights=[1]", *alone, "--json"))
    assert [row["scenario"] for row in said["scenarios"]] == ["my.toml, scale -1", "my.toml, scale 1"]


@pytest.mark.usefixtures("search")
def test_scenarios_on_the_command_line_stand_in_place_of_those_of_the_search():
    said = json.loads(succeeded("tune", "my.toml", "my.toml", "--scales=1", "--json"))
    assert [(row["scenario"], row["weight"]) for row in said["scenarios"]] == [("my.toml, scale 1", 1.0)] * 2


@pytest.mark.usefixtures("search")
def test_what_is_found_builds_on_the_scenario_with_one_line(tmp_path):
    found = json.loads(succeeded("tune", "my.toml", "--out", "gains.toml", "--json"))["parameters"]
    (tmp_path / "tuned.toml").write_text('base = "my.toml"\n' + (tmp_path / "gains.toml").read_text())
    assert_same_block(load_scenario(tmp_path / "tuned.toml"), load_scenario(tmp_path / "my.toml", found))


@pytest.mark.usefixtures("search")
def test_a_search_must_hold_its_own_scenario(tmp_path):
    (tmp_path / "third.toml").write_text(SQUARE)
    said = failed("tune", "third.toml")
    assert (
        "third.toml: tune.scenarios: those of my.toml, its base, are my.toml, square.toml, not this" in said
    )
    assert 'write [tune] with scenarios = ["third.toml"] and weights = [1]' in said
    (tmp_path / "fourth.toml").write_text(SQUARE + 'tune.scenarios = ["my.toml", "square.toml"]')
    said = failed("tune", "fourth.toml")
    assert "fourth.toml: tune.scenarios: must hold the scenario itself; they are" in said


@pytest.mark.usefixtures("search")
def test_a_number_that_another_scenario_does_not_have_is_named_with_its_file(tmp_path):
    (tmp_path / "square.toml").write_text(
        'base = "my.toml"\ncontroller = { type = "Backstepping", velocity_gain = 2000, force_gain = 1000 }\n'
    )
    message = failed("tune", "my.toml")
    assert f"my.toml: tune.vary.{GAIN}: is not a number of square.toml" in message


@pytest.mark.usefixtures("search")
def test_weights_of_an_option_are_counted_with_the_scenarios_of_the_search():
    assert "--weights = '1,2,3': must be a number above 0 for each scenario, with commas" in failed(
        "tune", "my.toml", "--weights", "1,2,3"
    )


def as_said(found):
    """What the command's JSON holds of what the library found."""
    rows = zip(found.names, found.before, found.after, strict=True)
    return {
        "parameters": dict(found.parameters),
        "scenarios": [{"scenario": name, "before": before, "after": after} for name, before, after in rows],
        "geometric_mean": found.cost,
        "runs": found.runs,
        "edges": list(found.edges),
    }


def said_by(*args):
    """That JSON without what only the command knows."""
    said = json.loads(succeeded(*args, "--json"))
    for row in said["scenarios"]:
        del row["weight"]
    return {name: said[name] for name in ("parameters", "scenarios", "geometric_mean", "runs", "edges")}


@pytest.mark.usefixtures("search")
def test_python_finds_what_the_command_finds():
    found = hydroservo.tune("square.toml")
    assert as_said(found) == said_by("tune", "square.toml")
    assert "my.toml, scale -1: " in repr(found)


@pytest.mark.usefixtures("search")
def test_arguments_in_python_are_the_options_of_the_command(tmp_path):
    (tmp_path / "fixed.py").write_text(PLUGIN)
    found = hydroservo.tune(
        [tmp_path / "my.toml", "square.toml"],
        {GAIN: hydroservo.relative(-0.5, 1.0), "controller.integral_gain": "1..10 V/m"},
        metric="max_error",
        weights=(1, 3),
        scales=[1],
        seeds=1,
        effort=0.1,
        candidates=128,
        seed=5,
        changes={"plant.mass": "7 kg", GAIN: 2.0},
        plugins=[tmp_path / "fixed.py"],
    )
    changes = ("--set", "plant.mass=7 kg", "--set", f"{GAIN}=2", "--plugin", tmp_path / "fixed.py")
    ranges = ("--vary", f"{GAIN}=-50%..+100%", "--vary", "controller.integral_gain=1..10 V/m")
    aim = ("--metric", "max_error", "--weights", "1,3", "--scales", "1", "--seeds", "1", "--effort", "0.1")
    length = ("--candidates", "128", "--seed", "5")
    files = (tmp_path / "my.toml", "square.toml")
    assert as_said(found) == said_by("tune", *files, *changes, *ranges, *aim, *length)


@pytest.mark.usefixtures("search")
def test_a_metric_that_another_scenario_does_not_have_is_named_with_what_says_it(tmp_path):
    text = 'base = "my.toml"\nmetrics.criteria.type = "IntegralCriteria"\n'
    (tmp_path / "own.toml").write_text(text + 'tune.scenarios = ["own.toml", "my.toml"]\n')
    assert "--metric = 'itae': must be one of" in failed("tune", "own.toml", "--metric", "itae")
    (tmp_path / "table.toml").write_text(
        text + 'tune.metric = "itae"\ntune.scenarios = ["table.toml", "my.toml"]\n'
    )
    assert "tune.metric = 'itae': must be one of" in failed("tune", "table.toml")
