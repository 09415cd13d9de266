"""Running one scenario."""

import json

import pandas as pd
import pytest

import hydroservo
from hydroservo.control.metrics import declared_metrics, usual
from hydroservo.core.formatting import NONE
from hydroservo.runs import results, run_finding
from hydroservo.runs.kernels import BEYOND
from hydroservo.runs.results import ResultFormat
from hydroservo.scenario import load_scenario, scenario_source
from hydroservo.show.files import json_value
from tests.support.bases import on_base
from tests.support.brink import brink_file
from tests.support.commands.runner import PLUGIN, QUICK, SHORT, UNSTABLE, hydroservo_, succeeded

METRICS = declared_metrics(usual(load_scenario("paper/sine-pi")))


def test_run_prints_metrics_in_engineers_units_and_a_verdict():
    text = succeeded("run", "paper/sine-pi", *QUICK)
    rows = {line.split()[1]: line.split() for line in text.splitlines() if line.startswith(("│", "|"))}
    metrics = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--json"))["metrics"]
    hidden = {"settling_time", "overshoot", "demand_jumps"}  # a sine does not jump
    assert set(METRICS) - set(rows) == {*hidden, "diverged", "diverged_at"}
    assert rows["rms_error"][3:6] == [f"{1e3 * metrics['rms_error']:.4g}", rows["rms_error"][4], "mm/s"]
    assert rows["control_rms"][5] == "mV"
    assert rows["oscillation_frequency"][3] == NONE
    assert "estimate_rms_error_1" not in rows  # a PI has no observer
    assert text.splitlines()[-2] == "The run did not diverge, and the piston stayed inside its stroke."
    assert text.splitlines()[-1].endswith("Sine; 20.0 ms at 100 kHz.")


def test_json_is_one_object_with_the_numbers_of_the_library():
    said = json.loads(succeeded("run", "paper/sine-tsmc", *QUICK, "--json"))
    loop = load_scenario("paper/sine-tsmc", {"simulation.duration": 0.02})
    data = hydroservo.simulate(loop, compiled=False)
    assert said == {
        "scenario": "paper/sine-tsmc",
        "hash": data.attrs["hash"],
        "version": hydroservo.__version__,
        "seed": 0,
        "diverged_by": "nothing",
        "warnings": [],
        "metrics": json_value(results.metrics_of(data)),
    }


def test_json_has_null_for_what_is_not_a_number():
    said = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--json"))
    assert said["metrics"]["diverged_at"] is None
    assert said["metrics"]["diverged"] is False


def test_compiled_and_interpreted_runs_say_the_same():
    compiled = succeeded("run", "paper/sine-pi", *SHORT, "--strict", "--json")
    assert compiled == succeeded("run", "paper/sine-pi", *QUICK, "--json")


@pytest.mark.parametrize("form", ResultFormat)
def test_out_gets_trajectory_metrics_and_plot(tmp_path, form):
    out = tmp_path / "a" / "b"
    text = succeeded("run", "paper/sine-pi", *QUICK, "--out", out, "--format", form)
    names = {f"trajectory{form.ending}", "metrics.csv", "metrics.json", "run.png", "run.svg", "report.html"}
    assert {path.name for path in out.iterdir()} == {*names, "tables"}
    assert all(name in text.splitlines()[-1] for name in (*names, "tables/"))


def test_files_of_a_run_agree_with_its_json(tmp_path):
    said = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--out", tmp_path, "--json"))
    written = json.loads((tmp_path / "metrics.json").read_text())
    assert written.pop("files").keys() == {
        *("metrics.csv", "report.html", "run.png", "run.svg", "trajectory.csv"),
        *("tables/metrics.csv", "tables/metrics.tex"),
    }
    assert written == said
    (row,) = pd.read_csv(tmp_path / "metrics.csv", dtype={"hash": str}).to_dict("records")
    assert [row[name] for name in ("scenario", "hash", "version", "seed")] == list(said.values())[:4]
    assert row["rms_error [m/s]"] == said["metrics"]["rms_error"]
    assert row["diverged"] == 0
    trajectory = pd.read_csv(tmp_path / "trajectory.csv")
    assert trajectory["time [s]"].iloc[-1] == pytest.approx(0.02)


def test_out_replaces_its_own_files_and_leaves_others(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "metrics.csv").write_text("old")
    succeeded("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (
        (tmp_path / "metrics.csv")
        .read_text()
        .startswith("scenario,hash,version,seed,diverged_by,rms_error [m/s],")
    )
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_run_says_that_it_diverged():
    text = succeeded("run", "paper/sine-pi", *QUICK, *UNSTABLE)
    assert "The run diverged: plant.velocity left physical reach, beyond 100 m/s at " in text


def test_a_large_error_alone_is_no_divergence():
    text = succeeded("run", "rig/1khz-pi-square", *SHORT, "--set", "reference.amplitude=1 mm/s")
    assert "The run did not diverge, and the piston stayed inside its stroke." in text.splitlines()
    assert "The loop does not follow" in text


def test_a_scenario_asks_for_metrics():
    asked = ("--set", "metrics.usual=false", "--set", "metrics.energy.type=Energy")
    text = succeeded("run", "paper/sine-pi", *QUICK, *asked)
    said = json.loads(succeeded("run", "paper/sine-pi", *QUICK, *asked, "--json"))
    assert list(said["metrics"]) == ["supply_energy", "valve_loss", "diverged", "diverged_at"]
    assert said["hash"] == json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--json"))["hash"]
    assert "The run did not diverge." in text.splitlines()


def test_run_says_that_the_piston_left_its_stroke():
    text = succeeded("run", "paper/sine-pi", *QUICK, "--set", "plant.start_position=78 mm")
    assert "The piston left its stroke: it went from 78 mm to 78." in text


def test_run_takes_a_file_and_a_users_own_controller(tmp_path):
    (tmp_path / "fixed.py").write_text(PLUGIN)
    (tmp_path / "my.toml").write_text(on_base('[controller]\ntype = "Fixed"\ncommand = "20 mV"\n'))
    args = ("run", tmp_path / "my.toml", *QUICK, "--json")
    said = json.loads(succeeded(*args, "--plugin", tmp_path / "fixed.py"))
    assert said["scenario"] == str(tmp_path / "my.toml")
    assert said["metrics"]["control_max"] == 0.02


def test_a_name_in_brackets_is_shown_as_it_is(tmp_path):
    (tmp_path / "[red]x.toml").write_text(scenario_source("paper/sine-pi"))
    assert "[red]x" in succeeded("run", tmp_path / "[red]x.toml", *QUICK)
    text = succeeded("compare", tmp_path / "[red]x.toml", "paper/sine-pi", *SHORT)
    assert "[red]x" in text


def test_verdict_puts_divergence_first():
    lost = {"diverged": ((), True), "diverged_at": ((), 1.0), "stroke_left": ((), True)}
    run = hydroservo.simulate(load_scenario("paper/sine-pi", {"simulation.duration": 0.001}), compiled=False)
    run = run.assign(lost).assign_attrs(diverged_by="controller.u")
    (line,) = run_finding.run_verdict(run)
    assert str(line) == "The run diverged: controller.u stopped being finite at 1.00 s."
    (line,) = run_finding.run_verdict(run.assign_attrs(diverged_by=f"plant.velocity {BEYOND} 100 m/s"))
    assert str(line) == "The run diverged: plant.velocity left physical reach, beyond 100 m/s at 1.00 s."


def test_a_loop_that_hunts_is_said_to_and_marked(tmp_path):
    """The crane's truth by a run of 40 s: 559 mV at 8.625 Hz."""
    shown = " ".join(succeeded("run", brink_file(tmp_path, "axis/crane"), "--out", tmp_path / "out").split())
    line = (
        "The loop oscillates for good at 8.60 Hz: 1.35 mm in the controlled signal and 560 mV in the command."
    )
    assert line in shown
    assert "A chamber is below atmospheric pressure for 995 ms" in shown
    assert line in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "oscillates at 8.60" in (tmp_path / "out" / "run.svg").read_text(encoding="utf-8")
    assert "oscillates" not in succeeded("run", "cases/encoder")


def test_a_loop_that_does_not_follow_is_said_to():
    wild = ("--set", "controller.integral_gain=60000", "--set", "simulation.duration=0.5s")
    shown = " ".join(succeeded("run", "rig/1khz-pi-sine", *wild).split())
    assert "The loop does not follow: its rms error is" in shown
    assert "does not follow" not in succeeded("run", "rig/1khz-pi-sine", *wild[2:])


def test_a_size_that_no_machine_has_is_said_once_and_before_the_run():
    wide = ("run", "axis/position", "--set", "plant.bore=63", "--set")
    refused = hydroservo_(*wide, "simulation.duration=1.5 ms").stderr.splitlines()
    unit = "is its unit right?"
    assert [unit in line for line in refused] == [True, True, False]  # two areas, and the duration
    ran = hydroservo_(*wide, "simulation.duration=1 ms").stderr.splitlines()
    assert sum(unit in line for line in ran) == 2
