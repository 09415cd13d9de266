"""That the counting of determinism sees what differs, and a short count."""

import json
import os
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

from tools.promises.determinism import CASES, Case, Surroundings, difference, drawn, outcome, plain

pytestmark = pytest.mark.nightly

ROOT = Path(__file__).parents[2]
HERE = Surroundings(sys.executable)


def test_files_that_differ_or_are_missing_are_named() -> None:
    assert difference({"a": "1", "b": "2"}, {"a": "1", "b": "2"}) == ""
    assert difference({"a": "1", "b": "2"}, {"a": "3", "c": "2"}) == "a, b, c"


def test_how_long_it_took_is_all_that_may_differ() -> None:
    fast, slow, other = (
        json.dumps({"runs": [{"mass": mass, "seconds": seconds}]}).encode()
        for mass, seconds in ((5.0, 0.1), (5.0, 9.0), (6.0, 0.1))
    )
    assert plain("a.json", fast) == plain("a.json", slow) != plain("a.json", other)
    assert plain("a.csv", b"seconds,1") == b"seconds,1"


def test_a_seed_determines_the_surroundings() -> None:
    first, second, tuning = (
        drawn(CASES[name], ["python"], ["C"], Random(4))
        for name in ("batch, strict", "batch, strict", "tune")
    )
    assert first == second
    assert {"HYDROSERVO_CPU_FEATURES", "PYTHONHASHSEED", "TZ", "LC_ALL"} <= first.environment.keys()
    assert first.options[0] == "--threads"
    assert "HYDROSERVO_CPU_FEATURES" not in tuning.environment


SET = """
from pathlib import Path
Path("out").mkdir()
Path("out/a").write_text(str(list({"a", "b", "c"})))
"""


def test_what_depends_on_the_hash_seed_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tools.promises.determinism.PROGRAM", SET)
    one = Case(["x"])
    found = [outcome(one, HERE._replace(environment={"PYTHONHASHSEED": str(i)}), tmp_path) for i in range(6)]
    assert "out/a" in {difference(found[0], other) for other in found[1:]}
    assert difference(found[0], outcome(one, HERE, tmp_path)) == ""


COUNT = """
from tools.promises import determinism
determinism.CASES = {name: determinism.CASES[name] for name in ("run, strict", "export c")}
print(sum(not row["broken"] for row in determinism.count_determinism(2, 1, lambda _: None)))
"""


def test_a_short_count_finds_no_difference() -> None:
    environment = {**os.environ, "HYDROSERVO_PYTHONS": ""}
    done = subprocess.run(
        [sys.executable, "-c", COUNT], cwd=ROOT, env=environment, text=True, capture_output=True, check=True
    )
    assert done.stdout.split() == ["2"]
