"""That the counting of promises sees what is broken, and a short count of each."""

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hydroservo import load_scenario, simulate
from hydroservo.engine import disk_cache
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.step_sizes import machine_paths
from tests.support.commands.processes import needs_posix
from tests.support.needs import needs
from tools.promises.cache import BY_ROOT, DAMAGES, Cache, loaded
from tools.promises.commands import COMMANDS
from tools.promises.faults import ERRORS, drawn
from tools.promises.forked import Ended
from tools.promises.kills import KILLED, Trial, judged
from tools.promises.left import files_in
from tools.promises.record import keep
from tools.promises.reference import follow
from tools.promises.soak import Sample, row_of
from tools.promises.traced import Fault
from tools.promises.trials import Folders, broken
from tools.promises.trials import Trial as Tried
from tools.promises.verdicts import VERDICTS, Judged, apart, count_verdicts, outcome, tallied

pytestmark = pytest.mark.nightly

ROOT = Path(__file__).parents[2]
DIED, WELL = Ended(KILLED, "", "", 1.0), Ended(0, "", "", 1.0)
OLD, NEW = ({"a.csv": f"{age} a", "metrics.json": f"{age} m"} for age in ("old", "new"))
HIDDEN = {".hydroservo-writing-01234567/a.csv": "half"}
TRIAL = Trial(COMMANDS["run"], Path(), (NEW,), 1.0, 1)


@pytest.mark.parametrize(
    ("after", "result", "told", "says"),
    [
        (OLD, DIED, [], []),
        (OLD | HIDDEN, DIED, [], []),
        (OLD | {"a.csv": "new a"} | HIDDEN, DIED, [], []),
        (NEW, WELL, [], []),
        (OLD | {"a.csv": "half"}, DIED, [], ["a.csv is neither the old nor the new file"]),
        (OLD | {"metrics.json": "new m"}, DIED, [], ["metrics.json came before another file"]),
        ({"a.csv": "old a"}, DIED, [], ["metrics.json is gone", "metrics.json came before another file"]),
        (OLD, DIED, ["parts/b"], ["parts/b was reported done and is not there"]),
        (NEW | HIDDEN, WELL, [], ["it ended well and left other files than it should"]),
        (OLD, Ended(1, "", "Traceback", 1.0), [], ["it ended with 1: Traceback"]),
    ],
)
def test_what_a_killed_command_may_not_leave_is_seen(after, result, told, says):
    assert judged(TRIAL, 0, OLD, after, result, told) == says


def test_a_part_of_the_record_leaves_the_others(tmp_path):
    found = tmp_path / "promises.json"
    for name, number in (("a", 0), ("b", 1)):
        keep(name, "scripts/promises", 3, [{"attempts": 2, "broken": number}] * 2, found)
    parts = json.loads(found.read_text())
    assert [(one["attempts"], one["broken"], one["seed"]) for one in parts.values()] == [(4, 0, 3), (4, 2, 3)]


Draw = random.Random
UNIT = "runs 0 to 127: module.py: Too many open files"
FAILED, LINE = ["write(3, ...)"], "hydroservo: out: cannot be written\n"


@pytest.fixture
def tried(tmp_path):
    folders = Folders(*(tmp_path / name for name in ("out", "temporary", "cache")))
    for folder in folders:
        folder.mkdir()
    (folders.out / "a.csv").write_text("old")
    return Tried(COMMANDS["tune"], folders, [{**files_in(folders.out), "a.csv": "new"}], Draw(0))


@pytest.mark.parametrize(
    ("status", "err", "writes", "says"),
    [
        (2, LINE, {}, []),
        (2, f"hydroservo: warning: it is slow\n{LINE}", {}, []),
        (2, f"hydroservo: 56 % done: part 3\n{LINE}", {}, []),
        (2, f"hydroservo: {UNIT}\nhydroservo: 1 of 5 units failed, such as {UNIT}\n", {}, []),
        (2, "", {}, ["it ended with 2 and said ''"]),
        (2, LINE * 2, {}, [f"it ended with 2 and said {LINE * 2!r}"]),
        (0, "", {}, ["it ended well and left other files than it should"]),
        (1, "Traceback", {}, ["it ended with 1: Traceback"]),
        (2, LINE, {"out/a.csv": "half"}, ["a.csv is neither the old nor the new file"]),
        (2, LINE, {"out/.hydroservo-writing-01234567": "half"}, ["it left hidden files"]),
        (2, LINE, {"temporary/half": "half"}, ["it left something else in the temporary folder"]),
    ],
)
def test_what_a_command_may_not_do_where_something_fails_is_seen(tried, status, err, writes, says):
    before = files_in(tried.folders.out)
    for name, text in writes.items():
        (tried.folders.out.parent / name).write_text(text)
    assert broken(tried, 0, before, Ended(status, "", err, 1.0), FAILED) == says


def test_a_line_that_cannot_be_written_is_not_missed_and_what_cannot_be_removed_may_stay(tried):
    before, silent = files_in(tried.folders.out), Ended(2, "", "", 1.0)
    assert broken(tried, 0, before, silent, ["7 write(2<pipe:[1]>, ...)"]) == []
    (tried.folders.out / ".hydroservo-writing-01234567").write_text("half")
    for call in ("unlink(...)", 'openat(5, "/out/.hydroservo-writing-01234567", O_RDONLY|O_CLOEXEC)'):
        assert broken(tried, 0, before, Ended(2, "", LINE, 1.0), [f"7 {call}"]) == []


def test_files_that_are_kept_elsewhere_are_whole(tried, tmp_path):
    before, kept = files_in(tried.folders.out), tmp_path / "hydroservo 1"
    kept.mkdir()
    (kept / "a.csv").write_text("half")
    said = Ended(2, "", f"hydroservo: out: cannot be written; kept in {kept} instead\n", 1.0)
    assert broken(tried, 0, before, said, FAILED) == [f"what it kept in {kept} is not whole"]


def test_each_call_fails_once_before_one_fails_again():
    errors = len(ERRORS["write"])
    faults = drawn({"write": {1, 3}, "mmap": set(), "open": {2}}, 4 * errors, Draw(0))
    assert sum(fault.kind == "open" for fault in faults) == 2 * errors
    writes = {fault for fault in faults if fault.kind == "write"}
    assert writes == {Fault("write", n, error) for n in (1, 3) for error in ERRORS["write"]}


def samples(memory, files=lambda _: 5):
    draw = Draw(0)
    return [Sample(10.0 * i, memory(i) + draw.gauss(0.0, 2.0), files(i)) for i in range(60)]


@pytest.mark.parametrize(
    ("memory", "files", "found"),
    [
        (lambda _: 400.0, lambda _: 5, 0),
        (lambda i: 400.0 + 10.0 * min(i, 12), lambda _: 5, 0),
        (lambda i: 400.0 + 0.5 * i, lambda _: 5, 1),
        (lambda _: 400.0, lambda i: 5 + i // 10, 1),
        (lambda i: 400.0 + 0.5 * i, lambda i: 5 + i // 10, 2),
    ],
)
def test_what_grows_after_the_warm_up_is_seen(memory, files, found):
    assert row_of("one", samples(memory, files), 600, 0)["broken"] == found
    assert row_of("one", samples(memory, files), 600, 3)["broken"] == found + 3


HALVES = """
import sys, time
from pathlib import Path
from hydroservo.core import outputs
from tools.promises import commands, kills

def in_two_halves(path, text):
    Path(path).parent.mkdir(exist_ok=True)
    with open(path, "w") as file:
        file.write(text[:9])
        file.flush()
        time.sleep(0.2)
        file.write(text[9:])

def broken():
    outputs.write_text = in_two_halves

one = commands.COMMANDS["tune"]
kills.COMMANDS = {"tune": one._replace(prepare=broken) if sys.argv[1] == "halves" else one}
print(kills.count_kills(int(sys.argv[2]), 0, lambda _: None)[0]["broken"])
"""


@pytest.mark.parametrize(
    ("said", "true", "found"),
    [
        (True, True, "rightly said"),
        (False, False, "rightly not said"),
        (True, False, "false"),
        (False, True, "missed"),
        (True, None, "no label"),
        (None, True, "no label"),
    ],
)
def test_a_verdict_and_its_label_are_held_against_each_other(said, true, found):
    one = Judged(dict.fromkeys(VERDICTS, said), dict.fromkeys(VERDICTS, true))
    assert outcome(one, "diverged") == found
    tally = tallied([one], "diverged")
    assert tally[found] == 1
    assert tally["broken"] + tally["wrong and warned"] == (found in ("false", "missed"))


def test_a_short_count_of_verdicts_finds_them_right():
    rows = {row["verdict"]: row for row in count_verdicts(16, 0, lambda _: None)}
    for name in ("diverged", "left the stroke", "below vacuum"):
        assert rows[name]["broken"] == 0
        assert rows[name]["rightly not said"] > 0
    assert rows["left the stroke"]["rightly said"] > 0


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("laws/lq-sine", {}),
        ("axis/position", {"reference.time": "0.05 s"}),
        ("axis/pump-controlled", {"reference.time": "0.05 s"}),
        ("axis/crane", {"reference.time": "0.05 s"}),
    ],
)
def test_machines_written_by_hand_move_as_the_blocks_do(name, changes):
    loop = load_scenario(name, {"simulation.duration": "0.2 s", **changes})
    *paths, _ = machine_paths(loop)
    data = simulate(loop, record=paths)
    states = np.stack([data[path].values for path in paths], axis=1)
    assert apart(states, follow(runnable_loop(loop), 1e-10, np.inf).states) < 1e-6


@needs_posix
@pytest.mark.parametrize(("how", "kills", "broken"), [("as it is", 4, False), ("halves", 10, True)])
def test_a_short_count_finds_half_files_if_there_are_any(how, kills, broken):
    words = [sys.executable, "-c", HALVES, how, str(kills)]
    done = subprocess.run(words, cwd=ROOT, text=True, capture_output=True, check=True)
    assert (int(done.stdout) > 0) == broken


COUNTS = """
import json
from tools.promises import cache, faults, places, soak
from tools.promises.cache import BY_ROOT, DAMAGES, Cache, loaded
from tools.promises.commands import COMMANDS

said = {}
ONE = {"tune": COMMANDS["tune"]}
if %(strace)r:
    faults.COMMANDS, faults.MORE = ONE, {}
    said["faults"] = faults.count_faults(5, 0)
if %(mount)r:
    places.COMMANDS = ONE
    # Other users may not be let into the folder in which all this lies.
    places.WHERE = {name: place for name, place in places.WHERE.items() if "disk" in name}
    said["places"] = places.count_places(5, 0)
cache.DAMAGES, cache.ELSEWHERE = {"bits flipped": cache.flipped}, {}
said["cache"] = cache.count_cache(20, 0)
tune, form = soak.commands()[3], lambda page: [lambda *_: page.asked("form")]
soak.commands, soak.requests = lambda: [tune], form
said["soak"] = soak.count_soak(1, 0, lambda _: None)
print(json.dumps(said))
"""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    place = tmp_path / "kernels"
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(place))
    for name in ("0", "1"):
        disk_cache.write_kernel(name, "f", bytes(range(256)))
    kept = {path.name: path.read_bytes() for path in place.iterdir()}
    return Cache(place, place / "0.kernel", place / "1.kernel", kept, "")


@needs_posix
@pytest.mark.parametrize("way", DAMAGES)
def test_what_is_damaged_is_not_loaded(cache, way):
    if DAMAGES[way] in BY_ROOT and os.getuid() != 0:
        pytest.skip("only root can give files away")
    assert loaded(cache) == ["it would be loaded"]
    for seed in range(10):
        cache.restore()
        DAMAGES[way](cache, Draw(seed))
        assert loaded(cache) == []


@needs_posix
def test_a_cache_that_asks_for_no_checksum_is_seen(cache, monkeypatch):
    monkeypatch.setattr(
        disk_cache, "verified_content", lambda folder, digest: folder.read(f"{digest}.kernel")[32:]
    )
    for way in ("bits flipped", "lengthened", "renamed to another loop's"):
        cache.restore()
        DAMAGES[way](cache, Draw(0))
        assert loaded(cache) == ["it would be loaded"]


def may_mount(folder):
    """Whether this user may mount a disk."""
    if os.getuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "test", folder], check=False).returncode:
        return False
    subprocess.run(["umount", folder], check=True)
    return True


@needs_posix
def test_a_short_count_of_each_finds_nothing_broken(tmp_path):
    needs("strace")
    code = COUNTS % {"strace": sys.platform == "linux", "mount": may_mount(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True, check=True)
    said = json.loads(done.stdout.splitlines()[-1])
    for row in said.pop("soak"):  # which has no time to grow warm
        assert row["attempts"] > 0
        assert row["failed"] == 0
    for name, rows in said.items():
        assert sum(row["attempts"] for row in rows) > 0, name
        assert sum(row["broken"] for row in rows) == 0, done.stdout
