"""Commands try their outputs first, keep what they computed, and leave a folder of one run."""

import errno
import importlib
import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from hydroservo.core.outputs import PREFIX
from hydroservo.figures import style
from hydroservo.runs import results
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import load_scenario
from hydroservo.show.files import foreign_files
from tests.support.commands.processes import HYDROSERVO, needs_posix
from tests.support.commands.runner import hydroservo_, succeeded

pytestmark = pytest.mark.nightly  # tests.regression runs each command

SHORT = ("--set", "simulation.duration=0.02")
RUN = ("run", "paper/sine-pi", *SHORT, "--interpreted")
COMPARE = ("compare", "paper/sine-pi", "paper/sine-tsmc", *SHORT)
BATCH = ("batch", "paper/sine-pi", *SHORT, "--vary", "plant.mass=4..8kg", "--runs", "5")
GAIN = ("--vary", "controller.proportional_gain=1..10")
TUNE = ("tune", "paper/sine-pi", *SHORT, *GAIN, "--candidates", "64")
FULL = "cannot be written: No space left on device"
COMMANDS = [
    (RUN, "DIR", "metrics.json", "hydroservo.runs.run.simulate"),
    (RUN, "DIR", "report.html", "hydroservo.runs.run.simulate"),
    (COMPARE, "DIR", "metrics.json", "hydroservo.runs.run.simulate"),
    (BATCH, "runs.csv", "", "hydroservo.runs.batch.simulate_batch"),
    (TUNE, "gains.toml", "", "hydroservo.runs.tuning.search_gains"),
    (("limit", "paper/sine-pi"), "DIR", "report.html", "hydroservo.limits.limit"),
    (("audit", "paper/sine-pi"), "DIR", "metrics.json", "hydroservo.audits.audit"),
    (("study", "small"), "DIR", "study.json", "hydroservo.studies.study.do_units"),
    (("study", "small"), "DIR", "report.html", "hydroservo.studies.study.do_units"),
    (("paper",), "DIR", "trajectories/sine-pi.nc", "hydroservo.papers.tsmc_eha_2021.study.run_study"),
    (("export", "c", "paper/sine-pi"), "DIR", "sine_pi.h", "hydroservo.export.products.proven_vectors"),
    (("export", "fmu", "paper/sine-pi"), "law.fmu", "", "hydroservo.export.products.proven_vectors"),
    (("export", "ssp", "paper/sine-pi"), "loop.ssp", "", "hydroservo.export.products.proven_vectors"),
]


@pytest.fixture(scope="module", autouse=True)
def imported():
    """What a test exchanges, no module imports meanwhile and keeps."""
    for *_, computes in COMMANDS:
        for module in (computes.rpartition(".")[0], "hydroservo.scenario.tuning"):
            importlib.import_module(module)


def never(*_args, **_options):
    raise AssertionError("computed before its outputs were tried")


@pytest.fixture(autouse=True)
def temporary(tmp_path_factory, monkeypatch):
    """The folder for temporary files."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


@needs_posix
@pytest.mark.parametrize(("words", "out", "file", "computes"), COMMANDS)
def test_what_cannot_be_replaced_is_said_before_anything_is_computed(
    tmp_path, monkeypatch, words, out, file, computes
):
    monkeypatch.setattr(computes, never)
    (tmp_path / out / file).parent.mkdir(parents=True, exist_ok=True)
    os.mkfifo(tmp_path / out / file)
    result = hydroservo_(*words, "--out", tmp_path / out)
    problem = f"{tmp_path / out / file}: cannot be written: Not a regular file"
    assert (result.exit_code, result.output) == (2, f"hydroservo: {problem}\n")


@pytest.mark.parametrize(("words", "out", "file", "computes"), COMMANDS)
def test_a_read_only_folder_is_said_before_anything_is_computed(
    tmp_path, monkeypatch, words, out, file, computes
):
    mkdir = Path.mkdir

    def refusing(path, *args, **options):
        if path.name.startswith(PREFIX):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))
        mkdir(path, *args, **options)

    monkeypatch.setattr(Path, "mkdir", refusing)
    monkeypatch.setattr(computes, never)
    result = hydroservo_(*words, "--out", tmp_path / out)
    assert result.exit_code == 2
    assert re.fullmatch(
        rf"hydroservo: {tmp_path}/.*: cannot be written: Read-only file system\n", result.output
    )


def full(folder, write):
    """A writer for which a folder's disk is full."""

    def writer(data, path, *more):
        if folder in path.parents:
            path.write_text("half")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        return write(data, path, *more)

    return writer


def test_a_batch_writes_the_other_files_and_keeps_the_lost_one_elsewhere(tmp_path, monkeypatch, temporary):
    monkeypatch.setattr(
        results.FORMATS[".parquet"], "write", full(tmp_path, results.FORMATS[".parquet"].write)
    )
    files = [tmp_path / name for name in ("runs.csv", "runs.parquet", "runs.png")]
    files[1].write_text("old")
    result = hydroservo_(*BATCH, *(word for file in files for word in ("--out", file)))
    assert result.exit_code == 2
    (kept,) = temporary.iterdir()
    assert result.stderr.splitlines()[-1] == f"hydroservo: {files[1]}: {FULL}; kept in {kept} instead"
    assert result.stdout.splitlines()[-1] == f"written: {files[0]}, {files[2]}"
    assert "rms_error" in result.stdout
    assert len(pd.read_parquet(kept / "runs.parquet")) == len(pd.read_csv(files[0])) == 5
    assert files[1].read_text() == "old"
    assert sorted(tmp_path.iterdir()) == sorted(files)


def test_a_defect_of_one_output_does_not_cost_the_others(tmp_path, monkeypatch):
    def defective(*_args):
        raise ZeroDivisionError

    monkeypatch.setattr("hydroservo.figures.batch.plot_batch", defective)
    result = hydroservo_(*BATCH, "--out", tmp_path / "runs.png", "--out", tmp_path / "runs.csv")
    assert result.exit_code == 1
    assert "\nhydroservo: a defect of hydroservo: ZeroDivisionError: ; with " in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]
    assert "rms_error" in result.stdout


def test_json_comes_before_the_failure(tmp_path, monkeypatch, temporary):
    monkeypatch.setattr(results.FORMATS[".csv"], "write", full(tmp_path, results.FORMATS[".csv"].write))
    result = hydroservo_(*BATCH, "--json", "--out", tmp_path / "runs.csv")
    assert result.exit_code == 2
    assert json.loads(result.stdout)["runs"] == 5
    assert "kept in" in result.stderr


@pytest.mark.parametrize("words", [RUN, COMPARE])
def test_a_folder_is_written_as_a_whole_or_kept_elsewhere_as_a_whole(tmp_path, monkeypatch, temporary, words):
    succeeded(*words, "--out", tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    save = style.Figure.savefig

    def savefig(figure, path, **options):
        if path.suffix == ".svg" and tmp_path in path.parents:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        save(figure, path, **options)

    monkeypatch.setattr(style.Figure, "savefig", savefig)
    result = hydroservo_(*words, "--set", "plant.mass=5", "--out", tmp_path)
    assert result.exit_code == 2
    assert "rms_error" in result.stdout
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    (kept,) = temporary.iterdir()
    assert result.stderr.endswith(f".svg: {FULL}; kept in {kept} instead\n")
    names = {path.relative_to(kept) for path in kept.rglob("*") if path.is_file()}
    assert names == {path.relative_to(tmp_path) for path in before}
    assert foreign_files(kept) == []


@pytest.mark.parametrize("words", [TUNE, ("export", "c", "paper/sine-pi", *SHORT)])
def test_text_that_cannot_be_written_is_kept_elsewhere(tmp_path, monkeypatch, temporary, words):
    write_text = Path.write_text

    def write(path, text, **options):
        write_text(path, text, **options)
        if tmp_path in path.parents:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr(Path, "write_text", write)
    result = hydroservo_(*words, "--out", tmp_path / "out")
    (kept,) = temporary.iterdir()
    assert result.exit_code == 2
    assert result.stderr.endswith(f": {FULL}; kept in {kept} instead\n")
    assert all(path.stat().st_size for path in kept.iterdir())
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_nothing_is_left_where_nothing_can_be_kept(tmp_path, monkeypatch, temporary):
    monkeypatch.setattr(results.FORMATS[".csv"], "write", full(Path("/"), results.FORMATS[".csv"].write))
    result = hydroservo_(*RUN, "--out", tmp_path)
    assert result.stderr == f"hydroservo: {tmp_path / 'trajectory.csv'}: {FULL}\n"
    assert not [*temporary.iterdir(), *tmp_path.iterdir()]


def test_a_disk_that_may_be_too_small_is_warned_of(tmp_path, monkeypatch):
    usage = type("Usage", (), {"free": 100})
    monkeypatch.setattr("shutil.disk_usage", lambda _folder: usage)
    result = hydroservo_(*RUN, "--out", tmp_path)
    assert result.exit_code == 0
    said = rf"hydroservo: warning: {tmp_path}: 9.54e-05 MiB are free, and about .*\n"
    assert re.fullmatch(said, result.stderr)


# --- whose files these are


def origin(path):
    """The hash of the run that a picture says it shows."""
    if path.suffix == ".png":
        with Image.open(path) as image:
            image.load()
            return image.text["Identifier"]
    found = re.search(r"<dc:identifier>(.*?)</dc:identifier>", path.read_text(encoding="utf-8"))
    return found[1]


def test_every_file_of_a_run_is_known_by_its_hash(tmp_path):
    said = json.loads(succeeded(*RUN, "--out", tmp_path, "--format", "parquet", "--json"))
    assert pd.read_csv(tmp_path / "metrics.csv", dtype=str)["hash"].tolist() == [said["hash"]]
    for name in ("run.png", "run.svg"):
        assert origin(tmp_path / name) == f"hydroservo {said['hash']}"
    assert foreign_files(tmp_path) == []


def test_pictures_of_several_runs_name_all(tmp_path):
    said = json.loads(succeeded(*COMPARE, "--out", tmp_path, "--json"))
    hashes = " ".join(run["hash"] for run in said["runs"])
    assert (
        origin(tmp_path / "comparison.png") == origin(tmp_path / "comparison.svg") == f"hydroservo {hashes}"
    )


def test_pictures_of_a_batch_name_its_scenario(tmp_path):
    files = [tmp_path / f"runs.{ending}" for ending in ("png", "svg", "pdf")]
    said = json.loads(succeeded(*BATCH, "--json", *(word for file in files for word in ("--out", file))))
    assert origin(files[0]) == origin(files[1]) == f"hydroservo {said['hash']}"
    assert f"hydroservo {said['hash']}".encode() in files[2].read_bytes()


# --- killed


def hidden(out):
    return [path for path in out.glob(".*") if path.is_dir()]


def killed_while_writing(out, mass, delay):
    """The exit status of a run that is killed some time after it has begun to write, if it lives so long."""
    out.mkdir(exist_ok=True)
    left = hidden(out)
    words = [*HYDROSERVO, *RUN, "--set", f"plant.mass={mass}", "--out", str(out)]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL) as running:
        while running.poll() is None and not any(
            (stage / "trajectory.csv").exists() for stage in hidden(out) if stage not in left
        ):
            time.sleep(0.002)
        time.sleep(delay)
        running.kill()
    return running.returncode


def whole(path):
    """Whether a file of a run has its beginning and its end."""
    if path.suffix == ".png":
        with Image.open(path) as image:
            image.load()
        return True
    text = path.read_text(encoding="utf-8")
    if path.name == "trajectory.csv":
        return text.count("\n") == 22 and text.endswith("\n")  # a header, and a row for each millisecond
    if path.suffix == ".html":
        return text.endswith("</html>")
    return text.endswith({".svg": "</svg>\n", ".json": "}\n", ".csv": "\n", ".tex": "\n"}[path.suffix])


def strangers(out):
    """Which files are named as another run's; all are whole, and the rest is of the run in metrics.json."""
    files = [path for path in out.rglob("*") if path.is_file()]
    visible = [path for path in files if not path.relative_to(out).parts[0].startswith(".")]
    assert [path for path in visible if not whole(path)] == []
    if not (out / "metrics.json").exists():  # the first run was killed
        return [path.name for path in visible]
    foreign = foreign_files(out)
    known = json.loads((out / "metrics.json").read_text())["hash"]
    for name in ("run.png", "run.svg"):
        assert (origin(out / name) == f"hydroservo {known}") == (name not in foreign)
    return foreign


def kill_and_look(out, times, seed):
    """How many runs were killed, how many left a mixture that was named, how many a hidden folder."""
    draw = np.random.default_rng(seed)
    killed = mixed = left = 0
    for i in range(times):
        killed += killed_while_writing(out, 4 + i % 3, draw.uniform(0.0, 0.9)) != 0
        mixed += bool(strangers(out))
        left += bool(hidden(out))
        assert len(hidden(out)) <= 1
    succeeded(*RUN, "--out", out)
    assert strangers(out) == []
    assert hidden(out) == []
    return killed, mixed, left


@needs_posix
def test_killed_runs_leave_whole_files_of_one_run_and_the_next_clears_the_rest(tmp_path):
    killed, _, left = kill_and_look(tmp_path, times=8, seed=1)
    assert killed > 0
    assert left > 0


@needs_posix
def test_a_run_clears_what_a_killed_one_left(tmp_path):
    assert killed_while_writing(tmp_path, 6, 0.0) == -signal.SIGKILL
    (stage,) = tmp_path.iterdir()
    assert (stage / "trajectory.csv").exists()
    succeeded(*RUN, "--out", tmp_path)
    assert strangers(tmp_path) == []
    assert not stage.exists()


@pytest.mark.parametrize(
    ("scenario", "varied"),
    [("axis/position", "plant.mechanism.mass=40..80 kg"), ("laws/mpc-sine", "plant.mass=4..8 kg")],
    ids=["whose start is found", "whose gains are found"],
)
def test_all_commands_give_a_scenario_one_hash(scenario, varied, tmp_path):
    asked = (scenario, "--set", "simulation.duration=20 ms", "--json")
    batch = ("batch", *asked, "--vary", varied, "--runs", "2")
    commands = (
        ("run", *asked),
        ("bode", *asked, "--linear"),
        batch,
        (*batch, "--out", f"{tmp_path / 'parts'}{os.sep}"),
        ("export", "c", *asked, "--out", tmp_path / "c"),
    )
    loop = load_scenario(scenario, {"simulation.duration": "20 ms"})
    assert {json.loads(succeeded(*words))["hash"] for words in commands} == {scenario_hash(loop)}
