"""[tune] of a scenario: what it says of a search, and what is refused."""

from pathlib import Path

import pytest

from hydroservo import ScenarioError
from hydroservo.control.controllers import TSMC
from hydroservo.core.block import leaves
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.scenario.load import assemble
from hydroservo.scenario.tune_table import SearchSettings
from hydroservo.scenario.tuning_task import task_of_scenarios
from hydroservo.testing.examples import example
from tests.support.bases import on_base

LAW = on_base(
    """\
[controller]
type = "PI"
proportional_gain = "2 V s/m"
integral_gain = "500 V/m"
"""
)
TUNE = """\
[tune]
scenarios = ["rig/1khz-pi-sine", "my.toml"]
weights = [1, 2.5]
scales = [-1, 0, 1]
metric = "max_error"
seeds = 3
effort = 0.1
candidates = 512
seed = 7

[tune.vary]
controller.integral_gain = "10..1000 V/m"
controller.proportional_gain = "-50%..+100%"
"""
TERMINAL = {  # what the law of the base lacks
    **{f"controller.{path}": value for path, value in leaves(example(TSMC)) if path.count("_gain_")},
    "controller.type": "TSMC",
    "controller.exponent_1": "5/7",
    "controller.exponent_2": "5/9",
    "controller.observer.type": "TSMObserver",
    "controller.observer.exponent": "5/7",
}


@pytest.fixture
def write(tmp_path: Path):
    def written(text: str, name: str = "my.toml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return written


def ranges_of(search: SearchSettings) -> dict[str, tuple[float, float]]:
    return {path: (one.low, one.high) for path, one in search.ranges.items()}


def test_each_scenario_holds_the_search_that_found_its_gains() -> None:
    for scenario in (name for name in scenarios() if not name.startswith("paper/")):
        assembly = assemble(scenario)
        numbers = dict(leaves(assembly.loop))
        assert scenario in (assembly.search.scenarios or [scenario])
        assert assembly.search.ranges, scenario
        for path, between in assembly.search.ranges.items():
            assert between.low <= numbers[path] <= between.high, (scenario, path)


def test_all_that_a_search_has(write) -> None:
    path = write(LAW + TUNE)
    search = assemble(path).search
    assert search._replace(ranges={}, together=None) == SearchSettings(
        scenarios=("rig/1khz-pi-sine", path),
        weights=(1.0, 2.5),
        scales=(-1.0, 0.0, 1.0),
        metric="max_error",
        seeds=3,
        effort=0.1,
        candidates=512,
        seed=7,
    )
    assert ranges_of(search) == {
        "controller.integral_gain": (10.0, 1000.0),
        "controller.proportional_gain": (1.0, 4.0),
    }


def test_without_a_table_there_is_nothing_to_search(write) -> None:
    assert assemble(write(LAW)).search == SearchSettings()


def test_a_search_is_no_part_of_the_loop(write) -> None:
    with_search, without = load_scenario(write(LAW + TUNE)), load_scenario(write(LAW, "other.toml"))
    assert with_search == without
    assert scenario_hash(with_search) == scenario_hash(without)


def test_the_order_of_paths_is_that_of_the_file(write) -> None:
    """Keys in quotes may stand in any; others by the table that they are in."""
    velocity = '{type = "FilteredDifference", time_constant = "2 ms"}'
    sensors = f'sensors = {{type = "RigSensors", position.type = "IdealPosition", velocity = {velocity}}}\n'
    paths = ("controller.integral_gain", "sensors.velocity.time_constant", "controller.proportional_gain")
    text = sensors + LAW + "[tune.vary]\n"
    quoted = write(text + "".join(f'"{path}" = "0.1..30"\n' for path in paths))
    assert list(assemble(quoted).search.ranges) == list(paths)
    plain = write(text + "".join(f'{path} = "0.1..30"\n' for path in paths))
    assert list(assemble(plain).search.ranges) == [paths[0], paths[2], paths[1]]


def test_a_search_lies_over_that_of_the_base(write) -> None:
    write(LAW + TUNE)
    text = 'base = "my.toml"\n[tune]\ncandidates = 64\nvary.controller.integral_gain = "1..2"'
    above = assemble(write(text, "own.toml")).search
    assert above._replace(ranges={}) == assemble(write(LAW + TUNE)).search._replace(candidates=64, ranges={})
    assert ranges_of(above)["controller.integral_gain"] == (1.0, 2.0)
    assert ranges_of(above)["controller.proportional_gain"] == (1.0, 4.0)


def test_another_law_drops_the_ranges_of_the_base(write) -> None:
    write(LAW + TUNE)
    terminal = "".join(f"{path} = {value!r}\n" for path, value in TERMINAL.items())
    own = write(f'base = "my.toml"\n{terminal}[tune.vary]\ncontroller.power_gain_1 = "1..9"', "o")
    assert ranges_of(assemble(own).search) == {"controller.power_gain_1": (1.0, 9.0)}
    changed = assemble(write(LAW + TUNE), TERMINAL)
    assert ranges_of(changed.search) == {}


def test_another_law_drops_a_range_of_the_base_that_is_in_another_unit(write) -> None:
    write(LAW + '[tune.vary]\ncontroller.proportional_gain = "1..9 V s/m"\n')
    cascade = """
        base = "my.toml"
        controls.type = "Position"
        reference = { type = "Step", initial = "9 mm", final = "10 mm" }
        [controller]
        type = "Cascade"
        proportional_gain = "10 1/s"
        max_velocity = "0.1 m/s"
        rate_feedforward = 1
        controller = { type = "PI", proportional_gain = "3 V s/m" }
    """
    assert assemble(write(cascade, "own.toml")).search.ranges == {}


def test_changes_lie_on_top(write) -> None:
    changes = {"tune.seeds": 5, "tune.vary.controller.integral_gain": "3..4 V/m"}
    search = assemble(write(LAW + TUNE), changes).search
    assert search.seeds == 5
    assert ranges_of(search)["controller.integral_gain"] == (3.0, 4.0)


def test_weights_of_a_base_wait_for_the_scenarios_that_they_are_of(write) -> None:
    law = '[controller]\ntype = "PI"\nproportional_gain = 2\nintegral_gain = 500\n'
    ranges = '[tune.vary]\ncontroller.proportional_gain = "1..3"\n'
    own = write('base = "laws/machine"\n' + law + ranges)
    assert assemble(own).search.weights == (1.0, 8.0)
    with pytest.raises(ScenarioError) as error:
        task_of_scenarios([own], {}, {}, {}, ())
    advice = "name them in tune.scenarios, or write tune.weights = [1]"
    assert str(error.value) == f"{own}: tune.weights: are for 2 scenarios; {advice}"
    assert task_of_scenarios([own], {}, {"weights": [3], "scales": [0]}, {}, ()).aim.weights == [3.0]
    assert task_of_scenarios([own], {}, {"scales": [0]}, {"tune.weights": [3]}, ()).aim.weights == [3.0]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("tune = 3", "tune: 3 must be a table: [tune]"),
        (
            "tune.candidate = 64",
            "tune.candidate: unknown key (value 64); it must be one of vary, scenarios, ",
        ),
        ("tune.candidate = 64", "did you mean candidates?"),
        ("tune.candidates = -1", "tune.candidates: -1 must be a whole number from 0 to 10000000"),
        ("tune.candidates = 64.0", "tune.candidates: 64.0 must be a whole number"),
        ("tune.candidates = true", "tune.candidates: True must be a whole number"),
        ("tune.seeds = 10001", "tune.seeds: 10001 must be a whole number from 1 to 10000"),
        ("tune.seed = -1", "tune.seed: -1 must be a whole number from 0 to "),
        ("tune.effort = -0.1", "tune.effort: -0.1 must be a finite number, at least 0"),
        ("tune.effort = nan", "tune.effort: nan must be a finite number, at least 0"),
        ('tune.metric = "rms"', "tune.metric: 'rms' must be one of rms_error, "),
        ("tune.metric = 1", "tune.metric: 1 must be the name of a metric"),
        ("tune.weights = 1", "tune.weights: 1 must be a number above 0 for each scenario"),
        ("tune.weights = [0]", "tune.weights: [0] must be a number above 0 for each scenario"),
        (
            'tune.scenarios = ["rig/1khz-pi-sine"]\ntune.weights = [1, 2]',
            "tune.weights: [1, 2] must be a number above 0 for each scenario; there are 1",
        ),
        ('tune.scales = ["1"]', "tune.scales: ['1'] must be different numbers"),
        ("tune.scales = [1, 1.0]", "tune.scales: [1, 1.0] must be different numbers"),
        ("tune.scales = [inf]", "tune.scales: [inf] must be different numbers"),
        ('tune.scenarios = "my.toml"', "tune.scenarios: 'my.toml' must be a list of scenarios"),
        ("tune.scenarios = [1]", "tune.scenarios: 1 must be a string"),
        (
            'tune.scenarios = ["rig/1khz-pi-sin"]',
            "'rig/1khz-pi-sin' is not a built-in name, and there is no such",
        ),
        ('tune.scenarios = ["rig/1khz-pi-sin"]', "did you mean rig/1khz-pi-sine?"),
        ("tune.vary = 3", "tune.vary: 3 must be a table: [tune.vary]"),
        ('tune.vary.controller = "1..2"', "tune.vary.controller: is not a number that can vary"),
        ('tune.vary.controller.gain = "1..2"', "tune.vary.controller.gain: must be one of controller."),
        ('tune.vary.plant.mass = "1..2"', "tune.vary.plant.mass: must be in the controller or sensors"),
        (
            "tune.vary.controller.integral_gain = 3",
            "tune.vary.controller.integral_gain: 3 must be a range, a string",
        ),
        ('tune.vary.controller.integral_gain = "3"', "'3' must be a range, a string such as"),
        (
            'tune.vary.controller.integral_gain = "1..2 mm"',
            "'1 mm' does not convert to V/m; it must be a finite",
        ),
        ('tune.vary.controller.integral_gain = "2..1"', "'2' is more than '1', its upper end"),
        (
            'tune.vary.controller.integral_gain = "-1..1"',
            "reaches -1; it must be a finite number at least 0 [V/m]",
        ),
        (
            'tune.vary.controller.anti_windup = "-1%..1%"',
            "is 0 in the scenario, so no percentage of it can be taken",
        ),
    ],
)
def test_what_is_wrong_is_one_line(write, text: str, problem: str) -> None:
    path = write(text + "\n" + LAW)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert str(caught.value).startswith(f"{path}: tune")
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_error_names_the_file_in_which_the_value_stands(write) -> None:
    write(LAW + '[tune.vary]\ncontroller.integral_gain = "1..2 mm"\n', "base.toml")
    with pytest.raises(ScenarioError, match=r"base\.toml: tune\.vary\.controller\.integral_gain: '1 mm' "):
        load_scenario(write('base = "base.toml"\ntune.seeds = 2\n'))
    with pytest.raises(ScenarioError, match=r"overridden: tune\.seeds: 0 must be"):
        load_scenario(write(LAW), {"tune.seeds": 0})
