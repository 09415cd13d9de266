"""Files that a user names: what is not a file, is too large or never ends is refused in a line."""

import os
import subprocess
import sys
import time
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from hydroservo.core.errors import HydroservoError, ScenarioError
from hydroservo.cosimulation.fmu import read_fmu
from hydroservo.identification.log import read_log
from hydroservo.scenario import load_plugin, load_scenario
from hydroservo.scenario.records import binary
from hydroservo.work.units import manifest_in
from tests.support.commands.processes import needs_posix

TIME = np.arange(40) * 1e-3
ROWS = {"time [s]": TIME, "command [V]": np.sin(TIME), "velocity [m/s]": np.cos(TIME), "spare": TIME}
ENDINGS = ("mat", "nc", "h5", "parquet", "mf4", "tdms", "csv")
READERS = {
    **dict.fromkeys(ENDINGS, lambda path: read_log(path, {})),
    "toml": load_scenario,
    "py": load_plugin,
    "fmu": load_plugin,
}


def matlab(path: Path, **rows: np.ndarray) -> Path:
    from scipy.io import savemat

    names = {header.partition(" [")[0]: values for header, values in {**ROWS, **rows}.items()}
    units = {header.partition(" [")[0]: header.partition(" [")[2][:-1] for header in ROWS}
    savemat(path, {**names, "units": units}, do_compression=True)
    return path


def parquet(path: Path, **rows: np.ndarray) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({**ROWS, **rows}), path)
    return path


@needs_posix
@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_what_is_not_a_regular_file_is_refused(ending: str, kind: str, tmp_path: Path) -> None:
    """And at once: a pipe that nobody writes to would be waited for, and a device never ends."""
    path = tmp_path / f"odd.{ending}"
    {"pipe": os.mkfifo, "device": lambda odd: odd.symlink_to("/dev/zero"), "folder": Path.mkdir}[kind](path)
    what = "a directory, not a file" if kind == "folder" else "not a regular file"
    with pytest.raises(ScenarioError, match=f"odd.{ending}: (cannot be read: )?is {what}"):
        READERS[ending](path)


@pytest.mark.parametrize(("ending", "write"), [("mat", matlab), ("parquet", parquet)])
def test_what_would_fill_the_memory_is_refused_before_it_is_read(
    ending: str, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / f"log.{ending}")
    assert read_log(path, {}).time.size == 40
    monkeypatch.setattr(binary, "MOST_READ", 3 * 40 * 8 - 1)
    with pytest.raises(ScenarioError, match=rf"log.{ending}: the columns to read take 0 MiB"):
        read_log(path, {})


@pytest.mark.slow  # some ten seconds
@needs_posix
def test_a_small_file_of_gigabytes_takes_little_memory(tmp_path: Path) -> None:
    """4 MB of zeros in a column that nobody asks for: it took 1.9 GiB."""
    path = matlab(tmp_path / "log.mat", bomb=np.zeros(120_000_000))
    assert path.stat().st_size < 4_000_000
    code = (
        "import resource, sys; from hydroservo.identification.log import read_log; read_log(sys.argv[1], {});"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 600_000  # KiB; the column alone has 940,000


def test_a_library_that_takes_too_much_or_too_long_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = matlab(tmp_path / "log.mat")
    monkeypatch.setattr(binary, "PATIENCE", 0.0)
    with pytest.raises(ScenarioError, match=r"log.mat: cannot be read as .mat: it takes more than 0 s"):
        read_log(path, {})
    monkeypatch.setattr(binary, "PATIENCE", 60.0)
    monkeypatch.setattr(binary, "MOST_MEMORY", 100 << 20)
    with pytest.raises(ScenarioError, match=r"log.mat: cannot be read as .mat: "):
        read_log(path, {})


READING = """
import sys
from pathlib import Path
from hydroservo.scenario.records.binary import open_in_process
with open_in_process(Path(sys.argv[1])) as table:
    print(*(header.text for header in table.headers), flush=True)
    sys.stdin.read()
"""


@needs_posix
@pytest.mark.skipif(not Path("/proc").exists(), reason="processes are counted in /proc")
def test_the_process_that_reads_ends_with_the_one_that_asks(tmp_path: Path) -> None:
    path = matlab(tmp_path / "log.mat")
    command = [sys.executable, "-c", READING, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as asking:
        assert asking.stdout is not None
        assert asking.stdout.readline().split()[0] == "time"
        assert readers_of(path) == 1
        asking.kill()
    for _ in range(100):
        if not readers_of(path):
            return
        time.sleep(0.1)
    pytest.fail("it still runs")


def readers_of(path: Path) -> int:
    """How many processes read a table."""
    count = 0
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = process.read_bytes().decode(errors="replace")
        except OSError:
            continue
        count += "table_process.py" in words and str(path) in words
    return count


@needs_posix
def test_nothing_is_left_of_what_was_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    damaged = matlab(tmp_path / "log.mat")
    damaged.write_bytes(damaged.read_bytes()[:300])
    with pytest.raises(ScenarioError, match=r"log.mat: "):
        read_log(damaged, {})
    assert list(temporary.iterdir()) == []


@pytest.mark.parametrize("position", [70, 200, 1500])
def test_a_flipped_bit_in_an_mdf_file_is_a_line(position: int, tmp_path: Path, capfd) -> None:
    asammdf = pytest.importorskip("asammdf")
    path, temporary = tmp_path / "log.mf4", tmp_path / "temporary"
    file = asammdf.MDF()
    file.append(
        [
            asammdf.Signal(np.sin(TIME), TIME, unit=unit, name=name)
            for name, unit in [("command", "V"), ("velocity", "m/s")]
        ]
    )
    file.save(path)
    content = bytearray(path.read_bytes())
    content[position] ^= 0xFF
    path.write_bytes(bytes(content))
    temporary.mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tempfile.tempdir", str(temporary))
        with suppress(ScenarioError):  # or what the bit was for does not matter
            read_log(path, {})
    assert capfd.readouterr() == ("", "")
    assert list(temporary.iterdir()) == []


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", b" " * (65 << 20))
    with pytest.raises(HydroservoError, match=r"^has a description of 65 MiB; at most 64 are read"):
        read_fmu(path)


@needs_posix
def test_a_manifest_that_is_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "batch.json")
    with pytest.raises(HydroservoError, match=r"batch.json: is not a regular file; give another --out"):
        manifest_in(tmp_path, "batch.json")


@pytest.mark.parametrize("name", ["time", "velocity"])
def test_numbers_that_nothing_measures_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    values = {"time": TIME.tolist(), "command": TIME.tolist(), "velocity": TIME.tolist()}
    values[name][-1] = 1e308
    lines = [f"{t!r},{u!r},{v!r}" for t, u, v in zip(*values.values(), strict=True)]
    path.write_text("\n".join(["time [s],command [V],velocity [m/s]", *lines]), encoding="utf-8")
    with pytest.raises(ScenarioError, match=rf"log.csv: {name}: has a number beyond 1e\+30 "):
        read_log(path, {})
