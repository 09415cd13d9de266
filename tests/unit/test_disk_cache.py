"""Kernels kept on disk: found again, never stale, never another's, and nothing that goes wrong matters."""

import errno
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import hydroservo
from hydroservo.engine import disk_cache

pytestmark = pytest.mark.slow  # a process for each run

posix = pytest.mark.skipif(os.name != "posix", reason="permissions are those of POSIX")

RUN = """
import json, sys
from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.testing.examples import example
loop = example(Loop, Simulation(0.01, 1e-3))
if len(sys.argv) > 1:
    sys.path.insert(0, sys.argv[1])
    import mine
    loop = replace(loop, {"controller": mine.Own()})
rms = float(simulate(loop, record=[])["rms_error"])
print(json.dumps([rms, "hydroservo.language.program" in sys.modules]))
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


@pytest.fixture
def own(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache of this process."""
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(place))
    return place


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


@pytest.mark.nightly
def test_a_known_loop_is_not_compiled_again(place: Path) -> None:
    first, compiled = ran(place)
    assert compiled
    assert ran(place) == (first, False)


def test_an_edited_component_is_seen(place: Path, tmp_path: Path) -> None:
    package = tmp_path / "source" / "hydroservo"
    package.parent.mkdir()
    copy(Path(hydroservo.__file__).parent, package)
    before, _ = ran(place, source=package.parent)
    law = package / "control" / "controllers" / "pi.py"
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
        if path.is_file() and path.suffix in (".py", ".pyi", ".toml"):
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


@pytest.mark.nightly
def test_an_edited_number_that_the_controller_imports_is_seen(place: Path, mine: Path) -> None:
    before, _ = ran(place, str(mine))
    (mine / "mine_gains.py").write_text("GAIN = 2.0\n")
    after, compiled = ran(place, str(mine))
    assert compiled
    assert after != before


@pytest.mark.nightly
def test_a_deleted_module_of_the_user_does_no_harm(place: Path, mine: Path) -> None:
    own, _ = ran(place, str(mine))
    others, _ = ran(place)
    (mine / "mine.py").unlink()
    assert ran(place) == (others, False)
    assert own != others


@pytest.mark.nightly
def test_two_processes_at_once(place: Path) -> None:
    processes = [started(place) for _ in range(2)]
    first, second = (finished(process)[0] for process in processes)
    assert first == second
    assert ran(place) == (first, False), "each left the kernel whole"


@pytest.mark.nightly
@pytest.mark.parametrize("damage", [b"", b"nonsense", None], ids=["empty", "nonsense", "cut"])
def test_damaged_files_are_made_anew(place: Path, damage: bytes | None) -> None:
    before, _ = ran(place)
    for file in place.glob("*.kernel"):
        whole = file.read_bytes()
        file.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert ran(place) == (before, True)
    assert ran(place) == (before, False)


@pytest.mark.nightly
def test_a_home_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a directory")
    before, compiled = ran(tmp_path / "file" / "cache")
    assert compiled
    assert ran(tmp_path / "file" / "cache") == (before, True)


def test_other_files_in_the_folder_are_left_alone(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "LARGEST", 100)
    own.mkdir(mode=0o700)
    (own / "precious").write_bytes(bytes(1000))
    disk_cache.write_kernel("0", "f", bytes(1000))
    assert sorted(path.name for path in own.iterdir()) == ["precious"]


def test_a_cache_that_can_only_be_read_serves(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise PermissionError

    disk_cache.write_kernel("0", "f", b"code")
    monkeypatch.setattr(os, "utime", refused)
    assert disk_cache.read_kernel("0") == ("f", b"code")


@posix
@pytest.mark.nightly
def test_code_that_others_could_have_written_is_not_loaded(place: Path) -> None:
    before, _ = ran(place)
    place.chmod(0o777)
    assert ran(place) == (before, True)


@posix
def test_the_cache_is_the_users_own(place: Path) -> None:
    ran(place)
    assert place.stat().st_mode & 0o777 == 0o700


def test_the_files_used_longest_ago_make_room(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "LARGEST", 2500)
    for i in range(4):
        disk_cache.write_kernel(f"{i}", "f", bytes(1000))
        os.utime(own / f"{i}.kernel", (i, i))
        disk_cache.read_kernel("0")
    assert sorted(path.stem for path in own.glob("*.kernel")) == ["0", "3"]
    assert disk_cache.read_kernel("3") == ("f", bytes(1000))
    assert disk_cache.read_kernel("1") is None


def refused(digest: str, says: str) -> None:
    with pytest.raises(disk_cache.CacheError, match=says):
        disk_cache.read_kernel(digest)


def test_what_is_kept_is_read(own: Path) -> None:
    assert disk_cache.read_kernel("0") is None
    disk_cache.write_kernel("0", "f", b"code\0more")
    assert disk_cache.read_kernel("0") == ("f", b"code\0more")
    assert sorted(path.name for path in own.iterdir()) == ["0.kernel"]


@posix
def test_what_is_kept_is_the_users_own(own: Path) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    assert own.stat().st_mode & 0o777 == 0o700
    assert {path.stat().st_mode & 0o777 for path in own.iterdir()} == {0o600}


@posix
@pytest.mark.parametrize("name", ["0.kernel", "."])
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o777])
def test_what_others_may_write_is_not_read(own: Path, name: str, mode: int) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    (own / name).chmod(mode | 0o100)
    refused("0", "is open to other users")


@posix
def test_a_folder_that_others_may_write_is_not_used(own: Path) -> None:
    own.mkdir()
    own.chmod(0o777)
    with pytest.raises(disk_cache.CacheError, match="is open to other users"):
        disk_cache.write_kernel("0", "f", b"code")
    assert not list(own.iterdir())


@posix
def test_a_folder_of_another_user_is_not_used(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    monkeypatch.setattr(os, "getuid", lambda: own.stat().st_uid + 1)
    refused("0", "belongs to another user")
    with pytest.raises(disk_cache.CacheError, match="belongs to another user"):
        disk_cache.write_kernel("1", "f", b"code")


@posix
def test_no_folder_is_made_among_files_of_another_user(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if own.parent.stat().st_uid == 0:
        os.chown(own.parent, 12345, 12345)
    monkeypatch.setattr(os, "getuid", lambda: own.parent.stat().st_uid + 1)
    with pytest.raises(disk_cache.CacheError, match="belongs to another user"):
        disk_cache.write_kernel("0", "f", b"code")
    assert not own.exists()


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="only root can give files away")
def test_a_file_of_another_user_is_not_read(own: Path) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    os.chown(own / "0.kernel", 12345, 12345)
    refused("0", "belongs to another user")
    disk_cache.write_kernel("0", "f", b"code")
    assert disk_cache.read_kernel("0") == ("f", b"code")


@posix
def test_links_and_pipes_are_not_read(own: Path) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    (own / "1.kernel").symlink_to(own / "0.kernel")
    os.mkfifo(own / "2.kernel", 0o600)
    with pytest.raises(OSError, match="symbolic links"):
        disk_cache.read_kernel("1")
    refused("2", "is not a file")


@posix
def test_a_link_to_the_users_own_folder_serves(own: Path) -> None:
    (own.parent / "elsewhere").mkdir(mode=0o700)
    own.symlink_to(own.parent / "elsewhere")
    disk_cache.write_kernel("0", "f", b"code")
    assert disk_cache.read_kernel("0") == ("f", b"code")


def test_a_renamed_file_is_not_read(own: Path) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    (own / "0.kernel").rename(own / "1.kernel")
    refused("1", "is damaged")


@pytest.mark.parametrize("at", [0, 31, 32, -1])
def test_a_changed_byte_is_noticed(own: Path, at: int) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    content = bytearray((own / "0.kernel").read_bytes())
    content[at] ^= 1
    (own / "0.kernel").write_bytes(content)
    refused("0", "is damaged")


def test_what_cannot_be_written_leaves_nothing(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    disk_cache.write_kernel("0", "f", b"code")
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space"):
        disk_cache.write_kernel("1", "f", b"code")
    assert sorted(path.name for path in own.iterdir()) == ["0.kernel"]


@pytest.mark.parametrize(
    "run", [lambda: disk_cache.read_kernel("0"), lambda: disk_cache.write_kernel("1", "f", b"code")]
)
def test_what_a_killed_process_left_is_cleared(own: Path, run: Callable[[], object]) -> None:
    disk_cache.write_kernel("0", "f", b"code")
    for name, age in (("new-old", 4000.0), ("new-young", 10.0)):
        (own / name).write_bytes(bytes(10))
        os.utime(own / name, (time.time() - age,) * 2)
    run()
    assert [path.name for path in own.glob("new-*")] == ["new-young"]


def test_what_is_being_written_counts(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disk_cache, "LARGEST", 2500)
    disk_cache.write_kernel("0", "f", bytes(1000))
    os.utime(own / "0.kernel", (1, 1))
    (own / "new-another").write_bytes(bytes(1000))
    disk_cache.write_kernel("1", "f", bytes(1000))
    assert sorted(path.name for path in own.glob("*-*")) == ["new-another"]
    assert [path.name for path in own.glob("*.kernel")] == ["1.kernel"]


def test_a_user_without_a_home_has_no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HYDROSERVO_CACHE_DIR")
    monkeypatch.setattr(disk_cache, "user_cache_path", lambda _: Path("~/.cache"))  # what is found then
    with pytest.raises(disk_cache.CacheError, match="no home directory"):
        disk_cache.write_kernel("0", "f", b"code")
