"""What goes wrong is one line, and nothing is half-written."""

import json
import re

import pytest

from hydroservo.runs import results
from tests.support.commands.runner import QUICK, SHORT, failed, hydroservo_

pytestmark = pytest.mark.slow  # it runs and draws


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


@pytest.mark.parametrize("out", [(), ("--out", "results")])
def test_what_does_not_fit_a_run_is_told_with_its_scenario(tmp_path, monkeypatch, out):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd.toml").write_text('base = "paper/sine-pi"\nsimulation.duration = "1.000005 s"\n')
    said = failed("compare", "paper/sine-pi", "odd.toml", *out)
    assert "odd.toml: simulation.period = 1e-05: must divide the duration" in said
    assert failed("run", "odd.toml", *out) == said
    huge = failed("run", "paper/sine-pi", "--set", "simulation.duration=1e9 s", *out)
    assert "paper/sine-pi: the recorded trajectory would take" in huge
    assert [path.name for path in tmp_path.iterdir()] == ["odd.toml"]


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
        (
            ("scenarios", "paper/sine-pi"),
            "no such command 'paper/sine-pi'; hydroservo scenarios show paper/sine-pi prints what has",
        ),
        (("studies", "small"), "no such command 'small'; hydroservo studies show small prints what has that"),
        (("run", "paper/sine-pi", "--out"), "option '--out' requires an argument (see"),
        (
            ("run", "paper/sine-pi", "--format", "cvs"),
            f"'cvs' is not one of {', '.join(map(repr, map(str, results.ResultFormat)))}",
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
    monkeypatch.setattr(results.FORMATS[".csv"], "write", half_written(KeyboardInterrupt()))
    (tmp_path / "trajectory.csv").write_text("old")
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    assert result.exit_code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["trajectory.csv"]
    assert (tmp_path / "trajectory.csv").read_text() == "old"


def test_a_full_disk_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(
        results.FORMATS[".csv"], "write", half_written(OSError(28, "No space left on device"))
    )
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    problem = f"{tmp_path / 'trajectory.csv'}: cannot be written: No space left on device"
    assert (result.exit_code, result.stderr) == (2, f"hydroservo: {problem}\n")
    assert "rms_error" in result.stdout
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("said", "why"), [("Unable to allocate 7 GiB", ": Unable to allocate 7 GiB"), ("", "")]
)
def test_too_little_memory_is_one_line(tmp_path, monkeypatch, said, why):
    monkeypatch.setattr(results.FORMATS[".csv"], "write", half_written(MemoryError(said)))
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    assert result.exit_code == 2
    assert "rms_error" in result.stdout  # what was computed is not lost
    assert f"there is too little memory{why}; record less often" in result.stderr
    assert result.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_library_that_the_system_does_not_load_is_one_line(tmp_path, monkeypatch):
    error = ImportError("x: failed to map segment")
    monkeypatch.setattr(results.FORMATS[".csv"], "write", half_written(error))
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path)
    assert result.exit_code == 2
    assert result.stderr == "hydroservo: a library cannot be loaded: x: failed to map segment\n"
    assert list(tmp_path.iterdir()) == []


def test_a_large_trajectory_is_announced(tmp_path, monkeypatch):
    monkeypatch.setattr("hydroservo.cli.run.LARGE_TRACE", 1000)
    result = hydroservo_("run", "paper/sine-pi", *QUICK, "--out", tmp_path, "--json")
    assert "MiB of memory" in result.stderr
    json.loads(result.stdout)
