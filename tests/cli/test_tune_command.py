"""``hydroservo tune``: what is printed and written."""

import json
import shlex
import tomllib

import numpy as np
import pytest

import hydroservo
from hydroservo.core.formatting import MINUS, NONE, brief
from tests.support.bases import on_base
from tests.support.commands.runner import PLUGIN, failed, succeeded
from tests.support.commands.tuning import (
    FEW,
    FILTER,
    GAIN,
    NAMES,
    QUICK,
    RUNAWAY,
    SHORT,
    TUNE,
    VARIED,
    WINDUP,
    again,
    flat,
    replay_in,
    rows_of,
)

pytestmark = pytest.mark.nightly  # tests.regression runs each command


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What a search printed, and the file that it wrote."""
    file = tmp_path_factory.mktemp("tune") / "new" / "gains.toml"
    return succeeded(*TUNE, "--out", file), file


@pytest.fixture(scope="module")
def said():
    return json.loads(succeeded(*TUNE, "--json"))


def test_json_is_one_object_whose_metrics_can_be_had_again(said):
    assert list(said) == [
        *(
            "command",
            "version",
            "parameters",
            "metric",
            "scenarios",
            "geometric_mean",
            "runs",
            "edges",
            "bounds",
            "margins",
            "first_guess",
            "front",
            "interrupted",
            "unstable",
        )
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
    assert rows[GAIN][-4:] == [f"{said['parameters'][GAIN]:.5g}", "0.3", "30", "V s/m"]
    assert rows[FILTER][-4:] == [brief(said["parameters"][FILTER], 5), brief(5e-5), "0.2", "s"]
    assert "rms_error before and after, mean over 3 seeds." in text
    assert "┃ before [mm/s] ┃ after [mm/s] ┃ change [%] ┃" in text
    for one in said["scenarios"]:
        weight, *numbers, change = rows[one["scenario"]]
        assert weight == f"{one['weight']:g}"
        assert numbers == [brief(1e3 * one[when]) for when in ("before", "after")]
        assert change == brief(100.0 * (one["after"] / one["before"] - 1.0), 3)
    _, _, after, change = rows["geometric mean"]
    assert after == brief(1e3 * said["geometric_mean"])
    assert change.startswith(MINUS)
    assert "384 closed loops were simulated." in text
    assert text.splitlines()[-1] == f"written: {file}"


def test_values_with_which_the_loop_diverged_have_no_metric(tmp_path):
    args = (*QUICK, *RUNAWAY, "--vary", f"{WINDUP}=1..100 1/s")
    assert rows_of(succeeded(*args))[NAMES[0]][1::2] == ["diverged", NONE]
    (one,) = json.loads(succeeded(*args, "--json"))["scenarios"]
    assert one["before"] is None
    assert one["after"] < 1.0


def test_the_replay_runs_and_gives_the_metric_shown():
    text = succeeded(*QUICK, *VARIED, "--set", f"{GAIN}=2")
    _, before, after, change = rows_of(text)[NAMES[0]]
    assert float(before) == pytest.approx(1e3 * again(NAMES[0], {GAIN: 2.0}, seeds=1), rel=1e-3)
    assert change == brief(100.0 * (float(after) / float(before) - 1.0), 3)
    words = replay_in(text)
    assert words[:3] == ["hydroservo", "run", NAMES[0]]
    metrics = json.loads(succeeded(*words[1:], "--json"))["metrics"]
    assert brief(1e3 * metrics["rms_error"]) == after


def test_the_replay_of_several_scenarios_compares_them(done, said):
    words = replay_in(done[0], "With these values and the first seed: ")
    assert words[:4] == ["hydroservo", "compare", *NAMES]
    runs = json.loads(succeeded(*words[1:], "--json"))["runs"]
    expected = [again(name, said["parameters"], seeds=1) for name in NAMES]
    assert [run["metrics"]["rms_error"] for run in runs] == pytest.approx(expected, rel=1e-9)


def test_a_metric_that_is_0_can_be_shown():
    power = ("--set", "metrics.power.type=CommandEnergy", "--set", "metrics.power.limit=1 V")
    calm = ("--set", f"{GAIN}=1", "--vary", f"{GAIN}=1..100", "--metric", "saturation_share")
    rows = rows_of(
        succeeded("tune", *NAMES, *SHORT, *power, *calm, *FEW)
    )  # large gains alone are at the limit
    assert rows[NAMES[0]] == ["1", "0", "0", NONE]
    assert rows["geometric mean"][1:] == ["0", "0", NONE]


def test_a_metric_that_is_0_with_all_candidates_is_one_line():
    calm = ("--vary", f"{GAIN}=1..2", "--metric", "overshoot")
    line = "metric = 'overshoot': is 0 with each of 64 candidates, which says nothing; use another"
    assert line in failed("tune", NAMES[0], *SHORT, *calm, *FEW)  # a sine has no jump


def test_a_value_at_an_end_is_said():
    edge = f"At an end of its range, so a wider one may hold better: {GAIN}."
    many = ("tune", NAMES[0], *SHORT, "--candidates", "256", "--vary")
    assert edge in succeeded(*many, f"{GAIN}=0.3..1")
    assert "At an end" not in succeeded(*many, f"{GAIN}=0.3..30")


def test_values_that_leave_a_loop_unstable_are_said():
    large = (*QUICK, "--vary", f"{GAIN}=50..100")
    assert f"Unstable for small motions: {NAMES[0]}" in succeeded(*large)
    assert json.loads(succeeded(*large, "--json"))["unstable"] == [NAMES[0]]
    assert json.loads(succeeded(*QUICK, "--vary", f"{GAIN}=0.3..3", "--json"))["unstable"] == []


@pytest.mark.parametrize(
    ("ends", "low", "high"),  # in the unit that was typed last
    [
        ("0.5 mV s/mm..2 V s/m", 0.5, 2.0),
        ("500..2000 mV s/m", 500.0, 2000.0),
        ("5e-01..2", 0.5, 2.0),
        ("-50%..+100%", 0.5, 2.0),
        ("x0.5..x2", 0.5, 2.0),
    ],
)
def test_ranges_take_units_and_percentages_of_the_scenarios_value(ends, low, high):
    rows = rows_of(succeeded(*QUICK, "--set", f"{GAIN}=1", "--vary", f"{GAIN}={ends}"))
    assert [float(end) for end in rows[GAIN][-3:-1]] == [low, high]
    assert low <= float(rows[GAIN][-4]) <= high
    assert rows[GAIN][-1] == ("mV s/m" if ends.endswith("mV s/m") else "V s/m")


def test_a_users_own_controller_can_be_searched(tmp_path):
    (tmp_path / "fixed.py").write_text(PLUGIN)
    (tmp_path / "my.toml").write_text(on_base('[controller]\ntype = "Fixed"\n'))
    args = ("tune", tmp_path / "my.toml", *SHORT[:6], "--plugin", tmp_path / "fixed.py", "--candidates", "64")
    text = succeeded(*args, "--vary", "controller.command=0..20 mV")
    words = replay_in(text)
    (after,) = (cells[2] for cells in rows_of(text).values() if cells[:1] == ["1"])  # a long path is folded
    metrics = json.loads(succeeded(*words[1:], "--json"))["metrics"]
    assert brief(1e3 * metrics["rms_error"]) == after


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
