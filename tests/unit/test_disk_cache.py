"""Kernels kept on disk: found again, never stale, and nothing that goes wrong with the files matters."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import hydroservo
from hydroservo.engine import disk_cache

pytestmark = pytest.mark.slow  # a process for each run

RUN = """
import json, sys
from hydroservo import Loop, Simulation, replace, simulate
loop = Loop(Simulation(0.01, 1e-3))
if len(sys.argv) > 1:
    sys.path.insert(0, sys.argv[1])
    import mine
    loop = replace(loop, {"controller": mine.Own()})
rms = float(simulate(loop, record=[])["rms_error"])
print(json.dumps([rms, "numba" in sys.modules]))
"""

OWN = """
from typing import NamedTuple
from hydroservo import ops
from mine_gains import GAIN

class State(NamedTuple):
    u: float

class Own(NamedTuple):
    gain: float = 50.0

    def init(self):
        return State(0.0)

    def step(self, s, y, r, dt):
        return State(ops.clip(GAIN * self.gain * (r.value - y.velocity), -10.0, 10.0))
"""


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "cache"


def started(place: Path, *arguments: str, source: Path | None = None) -> subprocess.Popen[str]:
    environment = {**os.environ, "HYDROSERVO_CACHE_DIR": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    if source is not None:
        environment["PYTHONPATH"] = str(source)
    command = [sys.executable, "-c", RUN, *arguments]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def finished(process: subprocess.Popen[str]) -> tuple[float, bool]:
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    rms, compiled = json.loads(out)
    return rms, compiled


def ran(place: Path, *arguments: str, source: Path | None = None) -> tuple[float, bool]:
    """The result of a run in a process of its own, and whether it compiled anything."""
    return finished(started(place, *arguments, source=source))


def test_a_known_loop_is_not_compiled_again(place: Path) -> None:
    first, compiled = ran(place)
    assert compiled
    assert ran(place) == (first, False)


def test_an_edited_component_is_seen(place: Path, tmp_path: Path) -> None:
    package = tmp_path / "source" / "hydroservo"
    package.parent.mkdir()
    copy(Path(hydroservo.__file__).parent, package)
    before, _ = ran(place, source=package.parent)
    law = package / "controllers" / "pi.py"
    text = law.read_text()
    assert "self.proportional_gain *" in text
    law.write_text(text.replace("self.proportional_gain *", "0.5 * self.proportional_gain *"))
    after, compiled = ran(place, source=package.parent)
    assert compiled
    assert after != before
    law.write_text(text)
    assert ran(place, source=package.parent) == (before, False)


def copy(package: Path, target: Path) -> None:
    for path in package.rglob("*"):
        if path.is_file() and path.suffix in (".py", ".toml"):
            (target / path.relative_to(package)).parent.mkdir(parents=True, exist_ok=True)
            (target / path.relative_to(package)).write_bytes(path.read_bytes())


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "mine.py").write_text(OWN)
    (folder / "mine_gains.py").write_text("GAIN = 1.0\n")
    return folder


def test_an_edited_controller_of_the_user_is_seen(place: Path, mine: Path) -> None:
    before, _ = ran(place, str(mine))
    assert ran(place, str(mine)) == (before, False)
    (mine / "mine.py").write_text(OWN.replace("-10.0, 10.0", "-0.5, 0.5"))
    after, compiled = ran(place, str(mine))
    assert compiled
    assert after != before


def test_an_edited_number_that_the_controller_imports_is_seen(place: Path, mine: Path) -> None:
    before, _ = ran(place, str(mine))
    (mine / "mine_gains.py").write_text("GAIN = 2.0\n")
    after, compiled = ran(place, str(mine))
    assert compiled
    assert after != before


def test_a_deleted_module_of_the_user_does_no_harm(place: Path, mine: Path) -> None:
    own, _ = ran(place, str(mine))
    others, _ = ran(place)
    (mine / "mine.py").unlink()
    assert ran(place) == (others, False)
    assert own != others


def test_two_processes_at_once(place: Path) -> None:
    processes = [started(place) for _ in range(2)]
    first, second = (finished(process)[0] for process in processes)
    assert first == second
    assert ran(place) == (first, False), "each left the kernel whole"


@pytest.mark.parametrize("damage", [b"", b"nonsense", None], ids=["empty", "nonsense", "cut"])
def test_a_damaged_file_is_made_anew(place: Path, damage: bytes | None) -> None:
    before, _ = ran(place)
    (file,) = place.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert ran(place) == (before, True)
    assert ran(place) == (before, False)


def test_a_home_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a directory")
    before, compiled = ran(tmp_path / "file" / "cache")
    assert compiled
    assert ran(tmp_path / "file" / "cache") == (before, True)


def test_other_files_in_the_folder_are_left_alone(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(place))
    monkeypatch.setattr(disk_cache, "LARGEST", 100)
    place.mkdir(mode=0o700)
    (place / "precious").write_bytes(bytes(1000))
    disk_cache.write("0", "f", bytes(1000))
    assert [path.name for path in place.iterdir()] == ["precious"]


def test_a_cache_that_can_only_be_read_serves(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise PermissionError

    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(place))
    disk_cache.write("0", "f", b"code")
    monkeypatch.setattr(os, "utime", refused)
    assert disk_cache.read("0") == ("f", b"code")


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions are those of POSIX")
def test_code_that_others_could_have_written_is_not_loaded(place: Path) -> None:
    before, _ = ran(place)
    place.chmod(0o777)
    assert ran(place) == (before, True)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions are those of POSIX")
def test_the_cache_is_the_users_own(place: Path) -> None:
    ran(place)
    assert place.stat().st_mode & 0o777 == 0o700


def test_the_files_used_longest_ago_make_room(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(place))
    monkeypatch.setattr(disk_cache, "LARGEST", 2500)
    for i in range(4):
        disk_cache.write(f"{i}", "f", bytes(1000))
        os.utime(place / f"{i}.kernel", (i, i))
        disk_cache.read("0")
    assert sorted(path.stem for path in place.iterdir()) == ["0", "3"]
    assert disk_cache.read("3") == ("f", bytes(1000))
    assert disk_cache.read("1") is None
