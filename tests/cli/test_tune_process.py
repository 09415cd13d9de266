"""``hydroservo tune``: progress, interruption, and what it says where something is wrong."""

import json
import time
from types import SimpleNamespace

import pytest

from hydroservo.cli import tune as command_module
from tests.support.bases import on_base
from tests.support.commands.processes import heavy_libraries_of, leaves_nothing, needs_posix, on_terminal
from tests.support.commands.runner import failed, hydroservo_, succeeded
from tests.support.commands.tuning import FEW, GAIN, NAMES, QUICK, RUNAWAY, SHORT, VARIED, WINDUP

pytestmark = pytest.mark.nightly  # tests.regression runs each command


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
        ((*VARIED, "--effort", "nan"), "effort = nan: must be a finite number, at least 0"),
        ((*VARIED, "--effort", "-1"), "effort = -1.0: must be a finite number, at least 0"),
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
            f"--vary: {GAIN}: is not a number of paper/sine-tsmc",
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
        lambda fraction, text: seen.append((fraction, text)),
        "m/s",
        SimpleNamespace(candidates=4096, bounds=None),
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


def test_scales_of_no_uncertainty_are_refused(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(on_base(""))
    vary = ("--vary", f"{GAIN}=0.3..30")
    assert "--scales = '-1,1': changes nothing" in failed("tune", own, *vary, "--scales=-1,1", *FEW)
    own.write_text(on_base("tune.scales = [0, 1]\n"))
    assert "tune.scales = '0,1': changes nothing" in failed("tune", own, *vary, *FEW)
