"""``hydroservo tune``: what is printed and written, and what it says where something is wrong."""

import json
import shlex
import time
import tomllib

import numpy as np
import pytest
from cli_runner import PLUGIN, failed, hydroservo_, succeeded
from test_cli_process import heavy_libraries_of, leaves_nothing, needs_posix, on_terminal

import hydroservo
from bases import on_base
from hydroservo import simulate
from hydroservo.cli import tune as command_module
from hydroservo.scenario import load_scenario, parse_override

NAMES = ("paper/sine-pi", "paper/square-pi")
GIVEN = (
    *("simulation.duration=50 ms", "simulation.period=1 ms", "simulation.substeps=4"),
    *("valve.type=FirstOrderValve", "valve.time_constant=10 ms"),
    *("sensors.type=RigSensors", "sensors.position={type='Encoder', resolution='1 um'}"),
    "sensors.velocity={type='FilteredDifference', time_constant='2 ms'}",
)
SHORT = [word for change in GIVEN for word in ("--set", change)]
GAIN, FILTER = "controller.proportional_gain", "sensors.velocity.time_constant"
VARIED = ("--vary", f"{GAIN}=0.3..30 V s/m", "--vary", f"{FILTER}=5e-05..0.2 s")
WINDUP = "controller.anti_windup"
RUNAWAY = ("--set", f"{WINDUP}=1e12", "--set", "controller.saturation.limit=50 mV")  # its integral overflows
FEW = ("--candidates", "64", "--seed", "2")
TUNE = ("tune", *NAMES, *SHORT, *VARIED, "--weights", "1,2.5", "--seeds", "3", *FEW)
QUICK = ("tune", NAMES[0], *SHORT, *FEW)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What a search printed, and the file that it wrote."""
    file = tmp_path_factory.mktemp("tune") / "new" / "gains.toml"
    return succeeded(*TUNE, "--out", file), file


@pytest.fixture(scope="module")
def said():
    return json.loads(succeeded(*TUNE, "--json"))


def again(scenario, parameters, metric="rms_error", seeds=3):
    """The mean of a metric over single runs, with values that are set as a user would."""
    changes = dict(map(parse_override, GIVEN)) | parameters
    runs = [load_scenario(scenario, changes | {"simulation.seed": seed}) for seed in range(seeds)]
    return np.mean([simulate(run, record=())[metric] for run in runs])


def flat(tables, prefix=""):
    for name, value in tables.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def rows_of(text):
    """The first cell of each row of the tables, and the others."""
    lines = (line.strip("│┃ ").replace("┃", "│") for line in text.splitlines() if line.startswith(("│", "┃")))
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in (line.split("│") for line in lines)}


def replay_in(text, start="with these values: "):
    """The words of the command that replays what was found."""
    (line,) = (line for line in text.splitlines() if line.startswith("with these values"))
    assert line.startswith(start)
    return shlex.split(line.removeprefix(start))


def test_json_is_one_object_whose_metrics_can_be_had_again(said):
    assert list(said) == [
        *("command", "version", "parameters", "metric", "scenarios", "geometric_mean", "runs", "edges")
    ]
    assert (said["version"], said["metric"]) == (hydroservo.__version__, "rms_error")
    assert list(said["parameters"]) == [GAIN, FILTER]
    assert 5e-5 <= said["parameters"][FILTER] <= 0.2
    assert said["runs"] == 64 * 3 * 2
    assert [one["scenario"] for one in said["scenarios"]] == list(NAMES)
    assert [one["weight"] for one in said["scenarios"]] == [1.0, 2.5]
    for one in said["scenarios"]:
        assert one["after"] == pytest.approx(again(one["scenario"], said["parameters"]), rel=1e-9)
        assert one["before"] == pytest.approx(again(one["scenario"], {}), rel=1e-9)
    first, second = (one["after"] for one in said["scenarios"])
    assert said["geometric_mean"] == pytest.approx((first * second**2.5) ** (1 / 3.5))


def test_the_command_in_the_result_finds_the_same_again(said):
    words = shlex.split(said["command"])
    assert words[0] == "hydroservo"
    assert words[1:] == [*TUNE[:3], *SHORT, *VARIED, "--weights", "1,2.5", "--seeds", "3", *FEW]
    assert json.loads(succeeded(*words[1:], "--json", "--threads", "1")) == said


def test_what_was_not_typed_is_not_in_the_command(tmp_path):
    out = ("--out", tmp_path / "gains.toml", "--threads", "1", "--json")
    ranges = ("--vary", f"{GAIN}=1..2")
    command = json.loads(succeeded(*QUICK, *ranges, *out))["command"]
    assert shlex.split(command)[1:] == ["tune", NAMES[0], *SHORT, *ranges, *FEW]


def test_the_file_has_tables_to_paste_under_the_command_that_found_them(done, said):
    text = done[1].read_text()
    tables = tomllib.loads(text)
    assert dict(flat(tables)) == said["parameters"]
    for one in said["scenarios"]:
        assert one["after"] == pytest.approx(again(one["scenario"], tables), rel=1e-9)
    comments = [line.removeprefix("# ") for line in text.splitlines() if line.startswith("#")]
    assert comments[0] == f"In SI units, found by hydroservo {hydroservo.__version__} with"
    pasted = "\n".join(comments[1:]).replace("\\\n", " ")  # as a shell joins lines
    assert shlex.split(pasted) == shlex.split(said["command"])
    assert max(map(len, comments)) < 100
    assert [path.name for path in done[1].parent.iterdir()] == ["gains.toml"]


def test_a_comment_stays_one_whatever_was_typed(tmp_path):
    file = tmp_path / "gains.toml"
    succeeded(*QUICK, "--vary", f"{GAIN}=1..2\n", "--out", file)
    assert dict(flat(tomllib.loads(file.read_text()))).keys() == {GAIN}


def test_the_screen_shows_values_metrics_and_a_replay(done, said):
    text, file = done
    rows = rows_of(text)
    assert rows[GAIN] == [f"{said['parameters'][GAIN]:.5g}", "0.3", "30", "V s/m"]
    assert rows[FILTER] == [f"{said['parameters'][FILTER]:.5g}", "5e-05", "0.2", "s"]
    assert "rms_error [mm/s], mean over 3 seeds" in text
    for one in said["scenarios"]:
        weight, *numbers, change = rows[one["scenario"]]
        assert weight == f"{one['weight']:g}"
        assert numbers == [f"{1e3 * one[when]:.4g}" for when in ("before", "after")]
        assert change == f"{100.0 * (one['after'] / one['before'] - 1.0):+.3g} %"
    _, _, after, change = rows["geometric mean"]
    assert after == f"{1e3 * said['geometric_mean']:.4g}"
    assert change.startswith("-")
    assert "384 closed loops were simulated." in text
    assert text.splitlines()[-1] == f"written: {file}"


def test_values_with_which_the_loop_diverged_have_no_metric(tmp_path):
    args = (*QUICK, *RUNAWAY, "--vary", f"{WINDUP}=1..100 1/s")
    assert rows_of(succeeded(*args))[NAMES[0]][1::2] == ["diverged", "-"]
    (one,) = json.loads(succeeded(*args, "--json"))["scenarios"]
    assert one["before"] is None
    assert one["after"] < 1.0


def test_the_replay_runs_and_gives_the_metric_shown():
    text = succeeded(*QUICK, *VARIED, "--set", f"{GAIN}=2")
    _, before, after, change = rows_of(text)[NAMES[0]]
    assert float(before) == pytest.approx(1e3 * again(NAMES[0], {GAIN: 2.0}, seeds=1), rel=1e-3)
    assert change == f"{100.0 * (float(after) / float(before) - 1.0):+.3g} %"
    words = replay_in(text)
    assert words[:3] == ["hydroservo", "run", NAMES[0]]
    metrics = json.loads(succeeded(*words[1:], "--json"))["metrics"]
    assert f"{1e3 * metrics['rms_error']:.4g}" == after


def test_the_replay_of_several_scenarios_compares_them(done, said):
    words = replay_in(done[0], "with these values and the first seed: ")
    assert words[:4] == ["hydroservo", "compare", *NAMES]
    runs = json.loads(succeeded(*words[1:], "--json"))["runs"]
    expected = [again(name, said["parameters"], seeds=1) for name in NAMES]
    assert [run["metrics"]["rms_error"] for run in runs] == pytest.approx(expected, rel=1e-9)


def test_a_metric_that_is_0_can_be_shown():
    calm = ("--set", f"{GAIN}=1", "--vary", f"{GAIN}=1..2", "--metric", "overshoot")
    rows = rows_of(succeeded("tune", *NAMES, *SHORT, *calm, *FEW))  # a sine has no jump
    assert rows[NAMES[0]] == ["1", "0", "0", "-"]
    assert rows["geometric mean"][1:] == ["0", "0", "-"]


def test_a_value_at_an_end_is_said():
    edge = f"AT THE EDGE of its range, so a wider one may hold better: {GAIN}"
    many = ("tune", NAMES[0], *SHORT, "--candidates", "256", "--vary")
    assert edge in succeeded(*many, f"{GAIN}=0.3..1")
    assert "AT THE EDGE" not in succeeded(*many, f"{GAIN}=0.3..30")


@pytest.mark.parametrize(
    ("ends", "low", "high"),
    [
        ("0.5 mV s/mm..2 V s/m", 0.5, 2.0),
        ("500..2000 mV s/m", 0.5, 2.0),
        ("5e-01..2", 0.5, 2.0),
        ("-50%..+100%", 0.5, 2.0),
    ],
)
def test_ranges_take_units_and_percentages_of_the_scenarios_value(ends, low, high):
    rows = rows_of(succeeded(*QUICK, "--set", f"{GAIN}=1", "--vary", f"{GAIN}={ends}"))
    assert [float(end) for end in rows[GAIN][1:3]] == [low, high]
    assert low <= float(rows[GAIN][0]) <= high


def test_a_users_own_controller_can_be_searched(tmp_path):
    (tmp_path / "fixed.py").write_text(PLUGIN)
    (tmp_path / "my.toml").write_text(on_base('[controller]\ntype = "Fixed"\n'))
    args = ("tune", tmp_path / "my.toml", *SHORT[:6], "--plugin", tmp_path / "fixed.py", "--candidates", "64")
    text = succeeded(*args, "--vary", "controller.command=0..20 mV")
    words = replay_in(text)
    (after,) = (cells[2] for cells in rows_of(text).values() if cells[:1] == ["1"])  # a long path is folded
    metrics = json.loads(succeeded(*words[1:], "--json"))["metrics"]
    assert f"{1e3 * metrics['rms_error']:.4g}" == after


@pytest.mark.parametrize(
    ("args", "problem"),
    [
        ((), "nothing to search: give --vary PATH=LOW..HIGH"),
        ((*VARIED, "--candidates", "0"), "--candidates = 0: must be a whole number from 1 to 10000000"),
        ((*VARIED, "--candidates", str(10**30)), "must be a whole number from 1 to 10000000"),
        ((*VARIED, "--seeds", "0"), "--seeds = 0: must be a whole number from 1 to 10000"),
        ((*VARIED, "--seed", "-1"), "--seed = -1: must be a whole number from 0 to 9223372036854775807"),
        ((*VARIED, "--metric", "rms"), "--metric = 'rms': must be one of rms_error, "),
        ((*VARIED, "--metric", "diverged"), "--metric = 'diverged': must be one of"),
        ((*VARIED, "--metric", "position_min"), "--metric = 'position_min': must be one of"),
        (
            (*VARIED, "--metric", "estimate_rms_error_1", "--set", f"{GAIN}=1"),
            "--metric = 'estimate_rms_error_1': must be one of rms_error, max_error, ",
        ),
        ((*VARIED, "--weights", "1,2"), "--weights = '1,2': must be a number above 0 for each scenario"),
        ((*VARIED, "--weights", "-1"), "--weights = '-1': must be a number above 0"),
        ((*VARIED, "--weights", "heavy"), "--weights = 'heavy': must be a number above 0"),
        ((*VARIED, "--scales", "1,one"), "--scales = '1,one': must be different numbers"),
        ((*VARIED, "--scales", "1,1"), "--scales = '1,1': must be different numbers"),
        ((*VARIED, "--effort", "nan"), "effort = nan: must be a finite number from 0 on"),
        ((*VARIED, "--effort", "-1"), "effort = -1.0: must be a finite number from 0 on"),
        ((*VARIED, "--weights", "nan"), "--weights = 'nan': must be a number above 0"),
        ((*VARIED, "--vary", f"{GAIN}=1..2"), f"--vary: {GAIN}: is given twice"),
        (("--vary", f"{GAIN}=2..1"), f"--vary: {GAIN}: '2' is more than '1', its upper end"),
        (("--vary", f"{GAIN}=0.1..2 mm"), f"--vary: {GAIN}: '0.1 mm' does not convert to V s/m"),
        (("--vary", f"{GAIN}=-1..2"), "reaches -1; it must be a finite number at least 0 [V s/m]"),
        (("--vary", "controller.gain=1..2"), "--vary: controller.gain: must be one of"),
        (("--vary", "plant.mass=4..8 kg"), "--vary: plant.mass: must be in the controller or sensors"),
        (("--vary", "simulation.seed=1..2"), "--vary: simulation.seed: "),
        (
            ("paper/sine-tsmc", "--vary", f"{GAIN}=1..2"),
            f"--vary: {GAIN}: is no number of paper/sine-tsmc",
        ),
        (
            (*RUNAWAY, "--vary", f"{WINDUP}=1e11..1e12"),
            "nothing found: with each of 64 candidates some run diverged",
        ),
        (("--set", "plant.mass=-1", *VARIED), "plant.mass: -1 must be"),
    ],
)
def test_a_wrong_option_is_one_line_and_writes_nothing(tmp_path, args, problem):
    file = tmp_path / "gains.toml"
    file.write_text("old")
    few = FEW if "--candidates" not in args and "--seed" not in args else ()
    assert problem in failed("tune", NAMES[0], *SHORT, *args, *few, "--out", file)
    assert [path.name for path in tmp_path.iterdir()] == ["gains.toml"]
    assert file.read_text() == "old"


def test_weights_say_how_many_are_wanted():
    assert "; there are 2" in failed("tune", *NAMES, *SHORT, *VARIED, "--weights", "1,2,3")


@pytest.mark.parametrize("args", [("--candidates", "many"), ("--threads", "0"), ("--nothing",)])
def test_wrong_usage_exits_with_2(args):
    assert "--help)" in failed(*QUICK, *VARIED, *args)


def test_help():
    text = succeeded("tune", "--help")
    assert "Usage" in text
    for option in ("--vary", "--metric", "--weights", "--seeds", "--candidates", "--seed", "--out", "--json"):
        assert option in text


def test_a_folder_that_cannot_be_made_is_said_before_the_search(tmp_path):
    (tmp_path / "file").write_text("old")
    start = time.monotonic()
    message = failed(
        "tune", "paper/sine-pi", *VARIED[:2], "--candidates", "1000000", "--out", tmp_path / "file" / "a.toml"
    )
    assert str(tmp_path / "file") in message
    assert time.monotonic() - start < 10.0


def test_steps_that_are_too_coarse_are_said():
    coarse = ("--set", "simulation.substeps=1", "--set", "valve.time_constant=0.5 ms")
    result = hydroservo_(*QUICK, *coarse, "--vary", f"{GAIN}=0.01..0.1", "--json")
    assert result.exit_code == 0
    assert result.stderr.startswith(f"hydroservo: warning: {NAMES[0]}: ")
    assert result.stderr.count("\n") == 1
    json.loads(result.stdout)


def test_progress_says_how_many_and_the_best_so_far():
    seen = []
    progress = command_module.progress_with_best(
        lambda fraction, text: seen.append((fraction, text)), "m/s", 4096
    )
    for fraction, best in ((0.25, float("inf")), (0.5, 2e-3), (1.0, 1.234e-3)):
        progress(fraction, best)
    assert seen == [
        (0.25, "1,024 of 4,096 candidates, best diverged"),
        (0.5, "2,048 of 4,096 candidates, best 2.00 mm/s"),
        (1.0, "4,096 of 4,096 candidates, best 1.23 mm/s"),
    ]


@needs_posix
def test_progress_is_shown_on_a_terminal_and_not_on_stdout():
    status, shown, stdout = on_terminal("stderr", *QUICK, *VARIED, "--json")
    assert status == 0
    assert json.loads(stdout)["runs"] == 64
    assert "candidates" in shown


@needs_posix
def test_ctrl_c_leaves_nothing_half_written(tmp_path):
    out = tmp_path / "out"
    args = ("tune", *NAMES, *VARIED[:2], "--candidates", "1000000", "--out", str(out / "gains.toml"))
    leaves_nothing(out, *args)


def test_tune_waits_with_heavy_libraries_until_they_are_used():
    assert heavy_libraries_of("hydroservo.cli.tune") == []


def test_scales_take_each_scenario_with_several_machines():
    """Scenario by scenario, each weight for all its machines."""
    two = ("--scales=-1,1", "--weights", "1,2")
    said = json.loads(succeeded("tune", *NAMES, *SHORT, *VARIED, *two, *FEW, "--json"))
    rows = said["scenarios"]
    assert [row["scenario"] for row in rows] == [
        f"{name}, scale {scale}" for name in NAMES for scale in (-1, 1)
    ]
    assert [row["weight"] for row in rows] == [1.0, 1.0, 2.0, 2.0]
    for row, name, scale in zip(rows, np.repeat(NAMES, 2), (-1.0, 1.0) * 2, strict=True):
        changes = said["parameters"] | {"uncertainty.scale": scale}
        assert row["after"] == pytest.approx(again(name, changes, seeds=1), rel=1e-9)


def test_scales_of_no_uncertainty_are_refused(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(on_base(""))
    vary = ("--vary", f"{GAIN}=0.3..30")
    assert "--scales = '-1,1': changes nothing" in failed("tune", own, *vary, "--scales=-1,1", *FEW)
    own.write_text(on_base("tune.scales = [0, 1]\n"))
    assert "tune.scales = '0,1': changes nothing" in failed("tune", own, *vary, *FEW)


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
@pytest.mark.slow
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
@pytest.mark.slow
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
    assert load_scenario(tmp_path / "tuned.toml") == load_scenario(tmp_path / "my.toml", found)


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
    assert f"my.toml: tune.vary.{GAIN}: is no number of square.toml" in message


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
