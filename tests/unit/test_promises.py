"""That the counting of promises sees what is broken, and a short count of kills."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hydroservo import load_scenario, simulate
from hydroservo.runs.run import ready
from hydroservo.runs.step_sizes import machine_paths
from tests.support.commands.processes import needs_posix
from tools.promises.commands import COMMANDS
from tools.promises.forked import Ended
from tools.promises.kills import KILLED, Trial, judged
from tools.promises.record import keep
from tools.promises.reference import follow
from tools.promises.verdicts import VERDICTS, Judged, apart, count_verdicts, outcome, tallied

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
    for name, broken in (("a", 0), ("b", 1)):
        keep(name, "scripts/promises", 3, [{"attempts": 2, "broken": broken}] * 2, found)
    parts = json.loads(found.read_text())
    assert [(one["attempts"], one["broken"], one["seed"]) for one in parts.values()] == [(4, 0, 3), (4, 2, 3)]


HALVES = """
import sys, time
from pathlib import Path
from hydroservo import outputs
from tools.promises import commands, kills

def in_two_halves(path, text):
    Path(path).parent.mkdir(exist_ok=True)
    with open(path, "w") as file:
        file.write(text[:9])
        file.flush()
        time.sleep(0.05)
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


@pytest.mark.slow  # it compiles several machines, by hand too
def test_a_short_count_of_verdicts_finds_them_right():
    rows = {row["verdict"]: row for row in count_verdicts(16, 0, lambda _: None)}
    for name in ("diverged", "left the stroke", "below vacuum"):
        assert rows[name]["broken"] == 0
        assert rows[name]["rightly not said"] > 0
    assert rows["left the stroke"]["rightly said"] > 0


@pytest.mark.slow  # each compiles a machine by hand
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
    assert apart(states, follow(ready(loop), 1e-10, np.inf).states) < 1e-6


@needs_posix
@pytest.mark.slow  # it imports everything, and runs commands for seconds
@pytest.mark.parametrize(("how", "kills", "broken"), [("as it is", 4, False), ("halves", 10, True)])
def test_a_short_count_finds_half_files_if_there_are_any(how, kills, broken):
    words = [sys.executable, "-c", HALVES, how, str(kills)]
    done = subprocess.run(words, cwd=ROOT, text=True, capture_output=True, check=True)
    assert (int(done.stdout) > 0) == broken
