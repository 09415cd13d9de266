"""`cache`."""

import json
import os

import pytest

from hydroservo.engine import disk_cache
from tests.support.commands.processes import needs_posix
from tests.support.commands.runner import failed, succeeded


@pytest.fixture
def place(tmp_path, monkeypatch):
    found = tmp_path / "kernels"
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(found))
    return found


@pytest.fixture
def kept(place):
    for name in ("0", "1"):
        disk_cache.write(name, "f", bytes(2**19))
    return place


def test_before_anything_is_kept(place):
    assert succeeded("cache") == f"folder   {place}, not made yet\n"
    assert json.loads(succeeded("cache", "--json"))["exists"] is False
    assert succeeded("cache", "--clear") == f"{place}: 0 kernels removed\n"


def test_what_is_kept(kept):
    folder, kernels, owner, trusted = succeeded("cache").splitlines()
    assert folder == f"folder   {kept}"
    assert kernels == "kernels  2, 1 MiB"
    assert trusted == "trusted  yes"
    found = json.loads(succeeded("cache", "--json"))
    size = sum(file.stat().st_size for file in kept.glob("*.kernel"))
    assert (found["place"], found["kernels"], found["bytes"]) == (str(kept), 2, size)
    assert found["trusted"]
    assert owner.split()[1] == (found["owner"] or "unknown")


def test_it_does_not_count_as_use(kept):
    os.utime(kept / "0.kernel", (1.0, 1.0))
    succeeded("cache")
    assert (kept / "0.kernel").stat().st_mtime == 1.0


def test_a_damaged_file_is_named(kept):
    (kept / "0.kernel").write_bytes(b"nonsense")
    assert f"refused  0.kernel: {kept / '0.kernel'} is damaged, or was not made here" in succeeded("cache")
    assert [*json.loads(succeeded("cache", "--json"))["refused"]] == ["0.kernel"]


@needs_posix
def test_a_folder_that_others_may_write_is_not_trusted_and_can_be_cleared(kept):
    kept.chmod(0o777)
    assert f"trusted  no: {kept} is open to other users; --clear" in succeeded("cache")
    assert json.loads(succeeded("cache", "--json"))["trusted"] is False
    assert succeeded("cache", "--clear") == f"{kept}: 2 kernels removed\n"
    assert not kept.exists()


def test_clearing_leaves_other_files_alone(kept):
    (kept / "mine.txt").write_text("mine")
    assert json.loads(succeeded("cache", "--clear", "--json"))["removed"] == 2
    assert [file.name for file in kept.iterdir()] == ["mine.txt"]


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="only root can give folders away")
def test_a_folder_of_another_user_is_not_cleared(kept):
    os.chown(kept, 12345, 12345)
    assert succeeded("cache").splitlines()[2] == "owner    12345"
    assert "belongs to another user" in failed("cache", "--clear")
    assert len([*kept.glob("*.kernel")]) == 2


def test_a_user_without_a_home(monkeypatch):
    monkeypatch.delenv("HYDROSERVO_CACHE_DIR")
    monkeypatch.setattr(disk_cache, "user_cache_path", lambda _: disk_cache.Path("~/.cache"))
    assert "this user has no home directory; set HYDROSERVO_CACHE_DIR" in failed("cache")
