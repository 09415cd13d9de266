"""Files take their places whole and together; what is left of a killed process goes; nothing else does."""

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from hydroservo import HydroservoError
from hydroservo.core.outputs import (
    LOCK,
    PREFIX,
    atomic_path,
    check_outputs,
    digests,
    staged,
    write_text,
)

needs_posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and locks")

STAYS = """
import sys, time
from hydroservo.core.outputs import staged, write_text
with staged(sys.argv[1]) as stage:
    write_text(stage / "file.csv", "half")
    print("ready", flush=True)
    time.sleep(60.0)
"""
KILLED_BETWEEN_RENAMES = """
import os, pathlib, signal, sys
from hydroservo.core.outputs import staged, write_text
renames, rename = int(sys.argv[2]), pathlib.Path.replace
def replace(self, target):
    global renames
    if renames == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    renames -= 1
    return rename(self, target)
pathlib.Path.replace = replace
with staged(sys.argv[1], last="b") as stage:
    for name in "abc":
        write_text(stage / name, "new")
"""


def texts(folder):
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


def hidden(folder):
    return [path.name for path in folder.iterdir() if path.name.startswith(".")]


# --- one file


def test_atomic_path_makes_folders_and_replaces(tmp_path):
    path = tmp_path / "a" / "b.txt"
    for text in ("one", "two"):
        with atomic_path(path) as temporary:
            assert temporary.name == path.name
            assert temporary.parent.parent == path.parent  # on the same disk
            temporary.write_text(text)
        assert path.read_text() == text
    assert list(path.parent.iterdir()) == [path]


def test_atomic_path_gives_the_usual_permissions(tmp_path):
    (tmp_path / "usual").write_text("")
    with atomic_path(tmp_path / "atomic") as temporary:
        temporary.write_text("")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("usual", "atomic")}
    assert len(modes) == 1


def write_half(path, error):
    with atomic_path(path) as temporary:
        temporary.write_text("half")
        raise error


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_atomic_path_keeps_the_old_file_where_writing_fails(tmp_path, error):
    path = tmp_path / "file.csv"
    path.write_text("old")
    with pytest.raises(error):
        write_half(path, error())
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_atomic_path_says_in_one_line_which_file_and_why(tmp_path):
    path = tmp_path / "file.csv"
    full = OSError(28, "No space left on device", "temporary")
    with pytest.raises(HydroservoError, match=r"file\.csv: cannot be written: No space left") as raised:
        write_half(path, full)
    assert "\n" not in str(raised.value)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_way_is_an_error_and_stays(tmp_path):
    (tmp_path / "file.csv").mkdir()
    with pytest.raises(HydroservoError, match="cannot be written"):
        write_text(tmp_path / "file.csv", "new")
    assert list(tmp_path.iterdir()) == [tmp_path / "file.csv"]


def test_a_file_for_a_folder_is_an_error(tmp_path):
    (tmp_path / "file").write_text("old")
    with pytest.raises(HydroservoError, match="cannot be written"):
        write_text(tmp_path / "file" / "run.csv", "new")


def test_text_is_written_as_it_is_in_utf_8(tmp_path):
    path = write_text(tmp_path / "a" / "b.txt", "1 m/s², 2 µs\n")
    assert path.read_bytes() == "1 m/s², 2 µs\n".encode()


# --- several files


def test_files_of_a_folder_take_their_places_together(tmp_path):
    (tmp_path / "notes").write_text("mine")
    (tmp_path / "a").write_text("old")
    with staged(tmp_path) as stage:
        write_text(stage / "a", "new")
        write_text(stage / "below" / "b", "new")
        assert digests(stage).keys() == {"a", "below/b"}
        assert (tmp_path / "a").read_text() == "old"
        assert not (tmp_path / "below").exists()
    assert texts(tmp_path) == {"notes": "mine", "a": "new", "below/b": "new"}
    assert not hidden(tmp_path)


def test_the_last_file_is_renamed_after_all_others(tmp_path, monkeypatch):
    order, rename = [], Path.replace
    monkeypatch.setattr(Path, "replace", lambda path, target: (order.append(path.name), rename(path, target)))
    with staged(tmp_path, last="b") as stage:
        for name in "abc":
            write_text(stage / name, "")
    assert order == ["a", "c", "b"]


def fails_after_one(folder, error):
    with staged(folder) as stage:
        write_text(stage / "a", "new")
        raise error


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, OSError])
def test_a_folder_stays_as_it_was_where_something_fails(tmp_path, error):
    (tmp_path / "a").write_text("old")
    with pytest.raises(HydroservoError if error is OSError else error):
        fails_after_one(tmp_path, error("it"))
    assert texts(tmp_path) == {"a": "old"}
    assert not hidden(tmp_path)


def test_an_error_names_the_place_and_not_the_hidden_folder(tmp_path):
    with staged(tmp_path) as stage:
        with pytest.raises(HydroservoError) as raised:
            write_half(stage / "below" / "a", OSError(28, "No space left on device"))
        write_text(stage / "b", "whole")
    assert str(raised.value) == f"{tmp_path / 'below' / 'a'}: cannot be written: No space left on device"
    assert texts(tmp_path) == {"b": "whole"}


def write_all(folder, names):
    with staged(folder) as stage:
        for name in names:
            write_text(stage / name, "new")


def test_no_file_takes_its_place_where_one_cannot(tmp_path):
    (tmp_path / "b").mkdir()
    with pytest.raises(HydroservoError, match=r"b: cannot be written: Is a directory"):
        write_all(tmp_path, "ab")
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


@needs_posix
def test_an_interrupt_does_not_part_files_that_take_their_places(tmp_path, monkeypatch):
    rename = Path.replace

    def interrupted(path, target):
        if path.name == "a":
            os.kill(os.getpid(), signal.SIGINT)
        return rename(path, target)

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_all(tmp_path, "abc")
    assert texts(tmp_path) == dict.fromkeys("abc", "new")
    assert not hidden(tmp_path)


# --- what others left


@needs_posix
def test_what_a_killed_process_left_goes_and_what_a_living_one_needs_stays(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", STAYS, tmp_path], text=True, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout.readline() == "ready\n"
        (theirs,) = hidden(tmp_path)
        write_text(tmp_path / "a", "")
        assert hidden(tmp_path) == [theirs]
        other.kill()
        other.wait()
        assert hidden(tmp_path) == [theirs]
        write_text(tmp_path / "a", "")
        assert not hidden(tmp_path)
    assert texts(tmp_path) == {"a": ""}


def test_processes_do_not_disturb_each_other(tmp_path):
    with staged(tmp_path) as one, staged(tmp_path) as other:
        write_text(one / "a", "one")
        write_text(other / "b", "other")
    assert texts(tmp_path) == {"a": "one", "b": "other"}


@needs_posix
@pytest.mark.parametrize("content", [(), (LOCK,), (LOCK, "below/file")])
def test_a_process_may_be_killed_at_any_point(tmp_path, content):
    stale = tmp_path / f"{PREFIX}0123abcd"
    stale.mkdir()
    for name in content:
        (stale / name).parent.mkdir(exist_ok=True)
        (stale / name).write_text("")
    write_text(tmp_path / "a", "")
    assert not hidden(tmp_path)


@needs_posix
@pytest.mark.parametrize("renames", range(3))
def test_killed_between_renames_the_last_file_is_still_the_old_one(tmp_path, renames):
    for name in "abc":
        write_text(tmp_path / name, "old")
    words = [sys.executable, "-c", KILLED_BETWEEN_RENAMES, tmp_path, str(renames)]
    assert subprocess.run(words, check=False).returncode == -signal.SIGKILL
    new = dict.fromkeys("acb"[:renames], "new")
    assert {name: (tmp_path / name).read_text() for name in "abc"} == dict.fromkeys("abc", "old") | new
    with staged(tmp_path):
        pass
    assert not hidden(tmp_path)


def test_only_hidden_folders_of_ours_are_removed(tmp_path):
    (tmp_path / f"{PREFIX}mine").mkdir()
    (tmp_path / f"{PREFIX}01234567").write_text("a file")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / LOCK).write_text("")
    if os.name == "posix":
        (tmp_path / f"{PREFIX}89abcdef").symlink_to(tmp_path / "elsewhere")
    (tmp_path / f"{PREFIX}00000000").mkdir()
    (tmp_path / f"{PREFIX}00000000" / "no-lock").write_text("")
    before = sorted(tmp_path.rglob("*"))
    write_text(tmp_path / "a", "")
    assert sorted(tmp_path.rglob("*")) == sorted([*before, tmp_path / "a"])


# --- before a long computation


def test_outputs_that_can_be_written_leave_no_trace(tmp_path):
    (tmp_path / "a").write_text("old")
    check_outputs([tmp_path / "a", tmp_path / "b", tmp_path / "new" / "folder" / "c"])
    assert texts(tmp_path) == {"a": "old"}
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def refuses(file, reason):
    with pytest.raises(HydroservoError) as raised:
        check_outputs([file])
    assert str(raised.value) == f"{file}: cannot be written: {reason}"


def test_a_folder_in_the_way_is_found(tmp_path):
    refuses(tmp_path, "Is a directory")


@needs_posix
def test_what_is_no_file_is_found_and_never_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    refuses(tmp_path / "pipe", "Not a regular file")
    with pytest.raises(HydroservoError, match="Not a regular file"):
        write_text(tmp_path / "pipe", "new")
    assert (tmp_path / "pipe").is_fifo()
    refuses(Path(os.devnull), "Not a regular file")


def test_a_file_where_a_folder_should_be_is_found(tmp_path):
    (tmp_path / "file").write_text("")
    refuses(tmp_path / "file" / "below" / "a", "Not a directory")


@pytest.mark.parametrize("code", [errno.EROFS, errno.EACCES])
def test_a_folder_that_takes_no_file_is_found(tmp_path, monkeypatch, code):
    mkdir = Path.mkdir

    def refusing(path, *args, **options):
        if path.name.startswith(PREFIX):
            raise OSError(code, os.strerror(code), str(path))
        mkdir(path, *args, **options)

    monkeypatch.setattr(Path, "mkdir", refusing)
    refuses(tmp_path / "a", os.strerror(code))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_full_disk_is_found(tmp_path, monkeypatch):
    opened = Path.open

    def full(path, *args, **options):
        return opened(Path("/dev/full") if path.name == LOCK else path, *args, **options)

    monkeypatch.setattr(Path, "open", full)
    refuses(tmp_path / "a", "No space left on device")
    assert not hidden(tmp_path)


@pytest.mark.parametrize(("code", "refused"), [(errno.EPERM, True), (errno.EACCES, os.name == "nt")])
def test_a_file_that_cannot_be_replaced_is_found(tmp_path, monkeypatch, code, refused):
    """One that may never change gives EPERM; one that is read-only makes way for its successor."""
    opened = Path.open

    def refusing(path, *args, **options):
        if path.name == "a":
            raise PermissionError(code, os.strerror(code), str(path))
        return opened(path, *args, **options)

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(Path, "open", refusing)
    if refused:
        refuses(tmp_path / "a", os.strerror(code))
    else:
        check_outputs([tmp_path / "a"])


INTERRUPTED = """
import os, signal, time
from hydroservo.core.outputs import uninterrupted

def work():
    for _ in range(10):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
    print("done", flush=True)
    time.sleep(0.1)

try:
    uninterrupted(work)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_work_ends_however_often_it_is_interrupted():
    """As by Ctrl-C, which a command repeats until it is heard."""
    command = [sys.executable, "-c", INTERRUPTED]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["done", "interrupted"], done.stderr
