import json
import math
import re
import shlex
from pathlib import Path

import pandas as pd
import pytest
from typer.main import get_command
from typer.testing import CliRunner

import hydroservo
from hydroservo import results
from hydroservo.cli.app import app, short_names
from hydroservo.cli.summary import RunSummary
from hydroservo.cli.tables import verdict
from hydroservo.metrics import METRIC_FIELDS
from hydroservo.papers.tsmc_eha_2021 import study as paper_study
from hydroservo.scenario import builtin_scenarios, load_scenario, parse_override, scenario_source
from needs import needs

SHORT = ("--set", "simulation.duration=0.02")  # s; 2000 samples
QUICK = (*SHORT, "--interpreted")

PLUGIN = '''
from typing import Annotated, NamedTuple

from hydroservo import Field


class FixedState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Fixed(NamedTuple):
    """A command that never changes."""

    command: Annotated[float, Field("V", "command")] = 0.01

    def init(self):
        return FixedState(0.0)

    def step(self, s, y, r, dt):
        return FixedState(self.command)
'''


def hydroservo_(*args):
    """Run the command line in this process."""
    return CliRunner().invoke(app, [str(arg) for arg in args])


def succeeded(*args):
    result = hydroservo_(*args)
    assert result.exit_code == 0, result.output
    return result.stdout


def failed(*args):
    """The one line that a command says on failing."""
    result = hydroservo_(*args)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    return result.stderr


# --- help and version


def test_version():
    assert succeeded("--version") == f"hydroservo {hydroservo.__version__}\n"


def test_no_arguments_show_help():
    assert "Usage: hydroservo" in CliRunner().invoke(app, [], prog_name="hydroservo").output


@pytest.mark.parametrize("command", ["", "run", "compare", "paper", "scenarios", "scenarios show"])
def test_help(command):
    assert "Usage" in succeeded(*command.split(), "--help")


def help_texts(command):
    """All that the help of a command and of those below it says."""
    yield command.help or ""
    yield from (getattr(param, "help", None) or "" for param in command.params)
    for inner in getattr(command, "commands", {}).values():
        yield from help_texts(inner)


COMMANDS = get_command(app)
QUOTED = re.findall(r"`([^`]+)`", "\n".join(help_texts(COMMANDS)))
EXAMPLES = sorted({text.removeprefix("hydroservo ") for text in QUOTED if text.startswith("hydroservo ")})
CHANGES = sorted({text for text in QUOTED if "=" in text} - {f"hydroservo {text}" for text in EXAMPLES})


def test_the_help_has_examples():
    assert len(EXAMPLES) >= 8
    assert len(CHANGES) >= 3


@pytest.mark.parametrize("example", EXAMPLES)
def test_each_example_of_the_help_runs(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hydroservo.scenario.plugins.loaded", {})
    Path("my_controller.py").write_text(PLUGIN)
    Path("my.toml").write_text('[controller]\ntype = "Fixed"\n')
    args = shlex.split(example.partition(" > ")[0])
    if args[:2] == ["export", "fmu"]:
        needs("cc")
    succeeded(*args, *{"run": QUICK, "compare": SHORT, "batch": SHORT}.get(args[0], ()))


@pytest.mark.parametrize("change", CHANGES)
def test_each_change_that_the_help_shows_is_one(change):
    load_scenario("paper/sine-pi", dict([parse_override(*shlex.split(change))]))


# --- scenarios


def test_scenarios_lists_each_with_its_title():
    text = succeeded("scenarios")
    for name, title in builtin_scenarios().items():
        assert [name, *title.split()] in [line.split() for line in text.splitlines()]


def test_scenarios_show_prints_the_source_as_it_is():
    assert succeeded("scenarios", "show", "paper/sine-tsmc") == scenario_source("paper/sine-tsmc")


def test_scenarios_show_names_what_is_not_there():
    assert "paper/sine-tsm" in failed("scenarios", "show", "paper/sine-tsm")


# --- run


def test_run_prints_metrics_in_engineers_units_and_a_verdict():
    text = succeeded("run", "paper/sine-pi", *QUICK)
    rows = {line.split()[1]: line.split() for line in text.splitlines() if line.startswith(("│", "|"))}
    metrics = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--json"))["metrics"]
    assert set(METRIC_FIELDS) <= set(rows)
    assert rows["rms_error"][3:6] == [f"{1e3 * metrics['rms_error']:.4g}", rows["rms_error"][4], "mm/s"]
    assert rows["control_rms"][5] == "mV"
    assert rows["estimate_rms_error_1"][3] == "-"
    assert text.splitlines()[-1] == "The run did not diverge, and the piston stayed inside its stroke."


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
        "metrics": results.plain(results.metrics_of(data)),
    }


def test_json_has_null_for_what_is_not_a_number():
    said = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--json"))
    assert said["metrics"]["estimate_rms_error_1"] is None
    assert said["metrics"]["diverged"] is False


def test_compiled_and_interpreted_runs_say_the_same():
    compiled = succeeded("run", "paper/sine-pi", *SHORT, "--strict", "--json")
    assert compiled == succeeded("run", "paper/sine-pi", *QUICK, "--json")


@pytest.mark.parametrize(
    ("form", "ending"), [("csv", "csv"), ("parquet", "parquet"), ("netcdf", "nc"), ("mat", "mat")]
)
def test_out_gets_trajectory_metrics_and_plot(tmp_path, form, ending):
    out = tmp_path / "a" / "b"
    text = succeeded("run", "paper/sine-pi", *QUICK, "--out", out, "--format", form)
    names = {f"trajectory.{ending}", "metrics.csv", "metrics.json", "run.png", "run.svg"}
    assert {path.name for path in out.iterdir()} == names
    assert all(name in text.splitlines()[-1] for name in names)


def test_files_of_a_run_agree_with_its_json(tmp_path):
    said = json.loads(succeeded("run", "paper/sine-pi", *QUICK, "--out", tmp_path, "--json"))
    written = json.loads((tmp_path / "metrics.json").read_text())
    assert written.pop("files").keys() == {"metrics.csv", "run.png", "run.svg", "trajectory.csv"}
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
    text = succeeded("run", "paper/sine-pi", *QUICK, "--set", "simulation.period=1 ms")
    assert text.splitlines()[-1].startswith("DIVERGED")


def test_run_says_that_the_piston_left_its_stroke():
    text = succeeded("run", "paper/sine-pi", *QUICK, "--set", "plant.start_position=78 mm")
    assert text.splitlines()[-1].startswith("LEFT THE STROKE: the piston went from 78 mm to 78.")


def test_run_takes_a_file_and_a_users_own_controller(tmp_path):
    (tmp_path / "fixed.py").write_text(PLUGIN)
    (tmp_path / "my.toml").write_text('[controller]\ntype = "Fixed"\ncommand = "20 mV"\n')
    args = ("run", tmp_path / "my.toml", *QUICK, "--json")
    said = json.loads(succeeded(*args, "--plugin", tmp_path / "fixed.py"))
    assert said["scenario"] == str(tmp_path / "my.toml")
    assert said["metrics"]["control_max"] == 0.02


def test_a_name_in_brackets_is_shown_as_it_is(tmp_path):
    (tmp_path / "[red]x.toml").write_text(scenario_source("paper/sine-pi"))
    assert "[red]x" in succeeded("run", tmp_path / "[red]x.toml", *QUICK)
    text = succeeded("compare", tmp_path / "[red]x.toml", "paper/sine-pi", *SHORT)
    assert "[red]x" in text


# --- compare


def test_compare_marks_the_best_of_each_row():
    text = succeeded("compare", "paper/sine-pi", "paper/sine-backstepping", *SHORT)
    rows = [line.replace("┃", "│").split("│") for line in text.splitlines() if line[0] in "┃│"]
    cells = {row[1].strip(): [cell.strip() for cell in row[2:-1]] for row in rows}
    assert cells["metric"] == ["unit", "paper/sine-pi", "paper/sine-backstepping"]
    unit, pi, backstepping = cells["rms_error"]
    assert unit == "mm/s"
    assert pi.endswith(" *")
    assert float(pi.removesuffix(" *")) < float(backstepping)
    assert "*" not in "".join(cells["position_max"])


def test_compare_marks_nothing_under_unequal_conditions(tmp_path):
    scenarios = [tmp_path / "one.toml", tmp_path / "other.toml"]
    for path, mass in zip(scenarios, ("6 kg", "7 kg"), strict=True):
        path.write_text(f'controller.type = "PI"\nplant.mass = "{mass}"\n')
    said = succeeded("compare", *scenarios, *SHORT)
    assert "*" not in said
    assert said.splitlines()[-1].split() == ["plant.mass:", "6", "kg,", "7", "kg"]
    out = tmp_path / "out"
    found = json.loads(succeeded("compare", *scenarios, *SHORT, "--json", "--out", out))
    assert found["comparable"] is False
    assert found["differences"] == {"plant.mass": [6.0, 7.0]}
    written = json.loads((out / "metrics.json").read_text())
    assert written.pop("files").keys() == {"comparison.png", "comparison.svg", "metrics.csv"}
    assert written == found


def test_compare_json_is_one_object_with_every_run_in_order():
    names = ["paper/sine-backstepping", "paper/sine-pi"]
    said = json.loads(succeeded("compare", *names, *SHORT, "--json"))
    assert list(said) == ["runs", "comparable", "differences"]
    assert said["comparable"] is True
    assert said["differences"] == {}
    assert [run["scenario"] for run in said["runs"]] == names
    alone = json.loads(succeeded("run", names[1], *SHORT, "--json"))
    assert said["runs"][1] == alone


def test_compare_writes_metrics_and_a_plot(tmp_path):
    names = ("paper/sine-pi", "paper/sine-backstepping")
    succeeded("compare", *names, *SHORT, "--out", tmp_path)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {"metrics.csv", "metrics.json", "comparison.png", "comparison.svg"}
    assert pd.read_csv(tmp_path / "metrics.csv")["scenario"].tolist() == list(names)
    said = json.loads((tmp_path / "metrics.json").read_text())
    assert [run["scenario"] for run in said["runs"]] == list(names)


def test_compare_says_which_run_diverged():
    text = succeeded("compare", "paper/sine-pi", "paper/sine-pi", *SHORT, "--set", "simulation.period=1 ms")
    assert text.count("paper/sine-pi: DIVERGED") == 2


def test_files_are_called_by_their_name_alone_where_that_is_clear():
    assert short_names(["a/x.toml", "paper/sine-pi"]) == ["x", "paper/sine-pi"]
    assert short_names(["a/x.toml", "b/x.toml"]) == ["a/x.toml", "b/x.toml"]


def test_verdict_puts_divergence_first():
    metrics = dict.fromkeys(METRIC_FIELDS, 1.0) | {"diverged": True, "stroke_left": True}
    both = RunSummary("name", "hash", "version", 0, "controller.u", [], metrics)
    assert "DIVERGED[/]: controller.u stopped being finite at 1.00 s" in verdict(both)
    assert "STROKE" not in verdict(both)
    error = both._replace(diverged_by="the error", metrics=metrics | {"diverged_at": math.nan})
    assert "DIVERGED[/]: in the second half the error passed both 10 peak demands" in verdict(error)


# --- paper


def test_paper_runs_the_study_writes_the_report_and_shows_verdicts(tmp_path, monkeypatch):
    from hydroservo.figures import report

    one = paper_study.Verdict(
        **dict.fromkeys(paper_study.Verdict._fields, ""),
    )._replace(claim="1", title="All track", reproduced=True, to_the_letter=False, holds=7, total=9)
    steps = []

    class Study:
        verdicts = (one,)

    def run_study(progress):
        progress(1, 2, "half")
        return Study

    def write_report(study, out, progress):
        progress(2, 2, "all")
        steps.append((study, out))
        return out / "report.html"

    monkeypatch.setattr(paper_study, "run_study", run_study)
    monkeypatch.setattr(report, "write_report", write_report)
    text = succeeded("paper", "--out", tmp_path / "report")
    assert steps == [(Study, tmp_path / "report")]
    row = next(line for line in text.splitlines() if "All track" in line)
    assert row.index("holds") < row.index("fails") < row.index("holds in 7 of 9")
    assert text.splitlines()[-1] == f"report: {tmp_path / 'report' / 'report.html'}"


# --- what goes wrong


def test_an_unknown_scenario_is_one_line():
    assert "paper/sine-pie" in failed("run", "paper/sine-pie")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ("plant.mass=-1 kg", "plant.mass"),
        ("plant.mas=1 kg", "plant.mas"),
        ("controller.saturation.limit=40 bar", "controller.saturation.limit"),
        ("simulation.period=3 us", "simulation.period"),
        ("nothing", "nothing"),
    ],
)
def test_a_wrong_change_is_one_line_that_names_it(change, named):
    assert named in failed("run", "paper/sine-pi", *SHORT, "--set", change)


@pytest.mark.parametrize(
    "args",
    [
        ("run",),
        ("run", "paper/sine-pi", "--format", "xlsx"),
        ("run", "paper/sine-pi", "--nothing"),
        ("nothing",),
        ("compare",),
    ],
)
def test_wrong_usage_is_one_line_that_names_the_help(args):
    assert re.search(r"^hydroservo: .* \(see hydroservo.* --help\)$", failed(*args))


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("run",), "missing argument 'SCENARIO' (see hydroservo run --help)"),
        (("run", "--nope"), "no such option: --nope (see"),
        (("run", "paper/sine-pi", "--se", "plant.mass=1"), "no such option: --se; did you mean --set? (see"),
        (("rnu",), "no such command 'rnu'. Did you mean 'run'? (see hydroservo --help)"),
        (
            ("scenarios", "shwo"),
            "no such command 'shwo'. Did you mean 'show'? (see hydroservo scenarios --help)",
        ),
        (("run", "paper/sine-pi", "--out"), "option '--out' requires an argument (see"),
        (
            ("run", "paper/sine-pi", "--format", "cvs"),
            "'cvs' is not one of 'csv', 'parquet', 'netcdf', 'mat'",
        ),
        (
            ("run", "paper/sine-pi", "more"),
            "got unexpected extra argument(s) (more) (see hydroservo run --help)",
        ),
        (("run", "--no\nsuch"), "no such option: --no\\"),
        (("run", "--" + "x" * 100_000), "..."),
    ],
)
def test_wrong_usage_says_what_is_wrong_and_what_is_near(args, said):
    message = failed(*args)
    assert said in message
    assert len(message) < 1100


@pytest.mark.parametrize("args", [(), ("export",)])
def test_a_command_that_lacks_its_command_shows_its_help(args):
    result = hydroservo_(*args)
    assert result.exit_code == 2
    assert "Usage: " in result.output
    assert "hydroservo: " not in result.stderr


def test_a_file_where_the_folder_should_be(tmp_path):
    (tmp_path / "file").write_text("old")
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path / "file")
    assert result.exit_code == 2
    message = failed("run", "paper/sine-pi", *QUICK, "--out", tmp_path / "file" / "inner")
    assert str(tmp_path / "file") in message
    assert (tmp_path / "file").read_text() == "old"


def half_written(error):
    def write(_dataset, path):
        path.write_text("half")
        raise error

    return write


def test_an_interrupt_while_writing_leaves_the_old_file(tmp_path, monkeypatch):
    monkeypatch.setitem(results.FORMATS, ".csv", half_written(KeyboardInterrupt()))
    (tmp_path / "trajectory.csv").write_text("old")
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    assert result.exit_code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["trajectory.csv"]
    assert (tmp_path / "trajectory.csv").read_text() == "old"


def test_a_full_disk_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(results.FORMATS, ".csv", half_written(OSError(28, "No space left on device")))
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    problem = f"{tmp_path / 'trajectory.csv'}: cannot be written: No space left on device"
    assert (result.exit_code, result.stderr) == (2, f"hydroservo: {problem}\n")
    assert "rms_error" in result.stdout
    assert list(tmp_path.iterdir()) == []


def test_a_large_trajectory_is_announced(tmp_path, monkeypatch):
    monkeypatch.setattr("hydroservo.cli.app.LARGE_TRACE", 1000)
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path, "--json")
    assert "MiB of memory" in result.stderr
    json.loads(result.stdout)
