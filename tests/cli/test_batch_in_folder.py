"""``hydroservo batch`` into a folder: what it leaves, how it goes on, and what it refuses in one line."""

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from hydroservo.core.errors import HydroservoError
from hydroservo.core.outputs import PREFIX
from hydroservo.scenario import stored_batch
from hydroservo.work import cluster
from tests.support.commands.processes import HYDROSERVO, needs_posix
from tests.support.commands.runner import failed, hydroservo_, succeeded
from tests.support.work.units import contents

pytestmark = pytest.mark.nightly  # tests.regression runs each command

SHORT = ("--set", "simulation.duration=5 ms", "--set", "simulation.period=0.1 ms")
BATCH = ("batch", "paper/sine-pi", *SHORT, "--vary", "plant.mass=4..8kg", "--runs", "600")
LONG = (
    "batch",
    "paper/sine-pi",
    "--set",
    "simulation.duration=1 s",
    "--vary",
    "plant.mass=4..8kg",
    "--runs",
    "100000",
)


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    monkeypatch.setattr(stored_batch, "MOST", 256)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The table of all runs, in memory and in a file, and what was said of it."""
    file = tmp_path_factory.mktemp("whole") / "runs.parquet"
    return json.loads(succeeded(*BATCH, "--json", "--out", file)), pd.read_parquet(file)


def test_a_folder_has_the_rows_of_the_file_and_says_the_same(tmp_path, whole):
    said = json.loads(succeeded(*BATCH, "--json", "--out", f"{tmp_path}/runs/"))
    assert said == whole[0]
    found = pd.read_parquet(tmp_path / "runs" / "parts").sort_values("run", ignore_index=True)
    pd.testing.assert_frame_equal(found, whole[1])
    assert len(list((tmp_path / "runs" / "parts").iterdir())) == 3


def test_files_and_pictures_go_beside_a_folder(tmp_path, whole):
    files = [word for name in ("all.parquet", "all.csv", "all.png") for word in ("--out", tmp_path / name)]
    text = succeeded(*BATCH, "--out", f"{tmp_path}/runs/", *files)
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "all.parquet"), whole[1])
    assert len(pd.read_csv(tmp_path / "all.csv")) == 600
    with Image.open(tmp_path / "all.png") as image:
        assert whole[0]["hash"] in image.text["Identifier"]
    assert f"written: {', '.join(map(str, files[1::2]))}" in text.splitlines()
    assert text.splitlines()[-1].startswith(f"written to {tmp_path}/runs: metrics.json, report.html, ")


def test_the_same_command_goes_on_and_says_how_much_was_there(tmp_path):
    folder = f"{tmp_path}/"
    assert "were there before" not in hydroservo_(*BATCH, "--out", folder).stderr
    before = contents(tmp_path)
    first, *_ = sorted((tmp_path / "parts").iterdir())
    rows = len(pd.read_parquet(first))
    first.unlink()
    assert f"; {600 - rows} were there before" in hydroservo_(*BATCH, "--out", folder).stderr
    assert "all runs were there before" in hydroservo_(*BATCH, "--out", tmp_path, "--threads", "1").stderr
    assert contents(tmp_path) == before


def test_a_part_that_was_cut_off_is_done_again_with_a_line(tmp_path):
    succeeded(*BATCH, "--out", f"{tmp_path}/")
    before = contents(tmp_path)
    first, *_ = sorted((tmp_path / "parts").iterdir())
    os.truncate(first, 1000)
    result = hydroservo_(*BATCH, "--out", f"{tmp_path}/")
    assert result.exit_code == 0
    assert f"hydroservo: {first}: is damaged, and done again if it is needed\n" in result.stderr
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("--runs", "601"), "belongs to a batch with runs 600, and not 601"),
        (("--seed", "1"), "belongs to a batch with seed 0, and not 1"),
        (("--vary", "load.offset=0..1N"), "belongs to a batch with vary "),
        (("--set", "plant.mass=7kg"), "belongs to a batch with another scenario"),
        (("--strict",), "belongs to a batch with strict False, and not True"),
    ],
)
def test_a_folder_of_another_batch_is_refused_and_left(tmp_path, change, said):
    succeeded(*BATCH, "--out", f"{tmp_path}/")
    before = contents(tmp_path)
    message = failed(*BATCH, *change, "--out", f"{tmp_path}/")
    assert message.startswith(f"hydroservo: {tmp_path}/batch.json: {said}")
    assert message.endswith("; give another --out\n")
    assert contents(tmp_path) == before


def test_a_folder_of_another_version_is_refused_and_left(tmp_path, monkeypatch):
    succeeded(*BATCH, "--out", f"{tmp_path}/")
    before = contents(tmp_path)
    monkeypatch.setattr("hydroservo.work.units.__version__", "9.9.9")
    assert failed(*BATCH, "--out", f"{tmp_path}/") == (
        f"hydroservo: {tmp_path}/batch.json: is of version 0.1.0 of hydroservo, and this is version 9.9.9; "
        "give another --out\n"
    )
    assert contents(tmp_path) == before


def test_an_attempt_that_left_no_part_does_not_bind_the_folder(tmp_path):
    succeeded(*BATCH, "--out", f"{tmp_path}/")
    for file in (tmp_path / "parts").iterdir():
        file.unlink()
    succeeded(*BATCH, "--seed", "1", "--out", f"{tmp_path}/")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--workers", "2"), "--workers and --scheduler compute the parts of a folder: give --out DIR"),
        (("--scheduler", "tcp://127.0.0.1:1"), "--workers and --scheduler compute the parts of a folder"),
        (
            ("--out", "runs/", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"),
            "--workers run on this machine, and --scheduler has its own: give one of the two",
        ),
        (("--out", "a/", "--out", "b/"), "--out: a/ and b/ are both folders; give one, and files"),
        (("--out", "runs/", "--runs", str(10**10)), "--runs = 10000000000: must be a whole number from 1 to"),
    ],
)
def test_a_wrong_option_is_one_line(tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    assert failed(*BATCH, *options).startswith(f"hydroservo: {said}")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_one_line(tmp_path):
    (tmp_path / "file").write_text("old")
    message = failed(*BATCH, "--out", f"{tmp_path}/file/")
    assert re.fullmatch(rf"hydroservo: {tmp_path}/file.*: cannot be written: Not a directory\n", message)
    assert (tmp_path / "file").read_text() == "old"


def test_a_scheduler_that_is_not_there_is_one_line_soon(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 1)
    start = time.monotonic()
    message = failed(*BATCH, "--out", f"{tmp_path}/", "--scheduler", "tcp://127.0.0.1:1")
    assert message == "hydroservo: no Dask scheduler answers at tcp://127.0.0.1:1 within 1 s\n"
    assert time.monotonic() - start < 12.0
    assert "missing port number" in failed(*BATCH, "--out", f"{tmp_path}/", "--scheduler", "nowhere")


def test_a_scheduler_is_asked_where_a_loop_runs_already_as_in_a_notebook(monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 1)

    async def cell():
        cluster.check_scheduler("tcp://127.0.0.1:1")

    with pytest.raises(HydroservoError, match=r"answers at tcp://127\.0\.0\.1:1 within 1 s"):
        asyncio.run(cell())


@pytest.mark.parametrize(
    ("words", "library", "said"),
    [
        ((*BATCH, "--scheduler", "tcp://127.0.0.1:1", "--out", "new/"), "distributed", "--scheduler needs"),
        ((*BATCH, "--out", "new/"), "pyarrow", "Parquet needs"),
        ((*BATCH, "--out", "new/runs.parquet"), "pyarrow", "Parquet needs"),
        (("run", "paper/sine-pi", "--format", "parquet", "--out", "new"), "pyarrow", "Parquet needs"),
        (("study", "small", "--out", "new"), "pyarrow", "Parquet needs"),
        (("log", "there.parquet"), "pyarrow", "Parquet needs"),
    ],
)
def test_a_missing_library_is_one_line(tmp_path, monkeypatch, words, library, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, library, None)
    Path("there.parquet").touch()
    extra = {"distributed": "cluster", "pyarrow": "parquet"}[library]
    assert failed(*words) == f"hydroservo: {said} {library}: pip install 'hydroservo[{extra}]'\n"
    assert library == "distributed" or not Path("new").exists()


@needs_posix
def test_a_full_disk_is_one_line_and_nothing_is_half_written(tmp_path):
    """No file may have more than so many bytes, which the system says as it says that a disk is full."""
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))\n"
        "from hydroservo.scenario import stored_batch; stored_batch.MOST = 256\n"
        "from hydroservo.cli import main; main()"
    )
    words = [*HYDROSERVO[:2], code, *BATCH, "--out", f"{tmp_path}/runs/"]
    done = subprocess.run(words, text=True, capture_output=True, check=False, timeout=120)
    part = rf"{tmp_path}/runs/parts/[0-9a-f]+\.parquet"
    assert re.fullmatch(rf"hydroservo: {part}: cannot be written: File too large\n", done.stderr)
    assert done.returncode == 2
    assert list(contents(tmp_path)) == ["runs/batch.json"]
    succeeded(*BATCH, "--out", f"{tmp_path}/runs/")
    succeeded(*BATCH, "--out", f"{tmp_path}/undisturbed/")
    assert contents(tmp_path / "runs") == contents(tmp_path / "undisturbed")


@needs_posix
@pytest.mark.parametrize("workers", [(), ("--workers", "2")])
def test_an_interrupt_keeps_what_is_done_and_says_how_to_go_on(tmp_path, workers):
    words = [*HYDROSERVO, *LONG, "--out", f"{tmp_path}/", *workers]
    with subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        while not list(tmp_path.glob("parts/*")) and running.poll() is None:
            time.sleep(0.05)
        running.send_signal(signal.SIGINT)
        stdout, stderr = running.communicate(timeout=60)
    says = f"; what is done is in {tmp_path}, and the same command goes on from there"
    assert re.sub("hydroservo: .* % done: .*\n", "", stderr) == (
        f"hydroservo: interrupted{says}; nothing was left half-written\n"
    )
    assert (running.returncode, stdout) == (130, "")
    assert not list(tmp_path.rglob(f"{PREFIX}*"))


def test_numbers_of_runs_go_on_over_parts(tmp_path):
    succeeded(*BATCH, "--seeds", "--set", "simulation.seed=7", "--out", f"{tmp_path}/")
    found = pd.read_parquet(tmp_path / "parts").sort_values("run")
    assert np.array_equal(found["run"], np.arange(600))
    assert np.array_equal(found["simulation.seed"], 7 + np.arange(600))
