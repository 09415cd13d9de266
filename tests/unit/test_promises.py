"""That the counting of promises sees what is broken, and a short count of kills."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.commands.processes import needs_posix
from tools.promises.commands import COMMANDS
from tools.promises.forked import Ended
from tools.promises.kills import KILLED, Trial, judged
from tools.promises.record import keep

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


@needs_posix
@pytest.mark.slow  # it imports everything, and runs commands for seconds
@pytest.mark.parametrize(("how", "kills", "broken"), [("as it is", 4, False), ("halves", 10, True)])
def test_a_short_count_finds_half_files_if_there_are_any(how, kills, broken):
    words = [sys.executable, "-c", HALVES, how, str(kills)]
    done = subprocess.run(words, cwd=ROOT, text=True, capture_output=True, check=True)
    assert (int(done.stdout) > 0) == broken
