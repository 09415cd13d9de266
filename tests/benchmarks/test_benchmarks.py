"""The benchmark runs, its contenders agree, and the pages show what it measured."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.__main__ import keep
from benchmarks.machine import described
from benchmarks.machines import INTEGRATORS, loops
from benchmarks.peer import TOLERANCE, difference
from benchmarks.profile import PARTS, in_process
from benchmarks.results import load, save
from benchmarks.table import chapters, details, filled, job_table, machines_table, summary

pytestmark = pytest.mark.nightly

ROOT = Path(__file__).parents[2]
PEERS = "hydroservo,C scalar,C SIMD,numba by hand"


def run(*options: str, path: str = os.environ["PATH"]) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchmarks", "--quick", "--rounds", "1", *options]
    surroundings = os.environ | {"PATH": path}
    return subprocess.run(command, cwd=ROOT, env=surroundings, capture_output=True, text=True, check=True)


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    out = tmp_path_factory.mktemp("benchmarks") / "results.json"
    run("--jobs", "J1,J2,J3,J4,J5", "--peers", PEERS, "--out", str(out))
    section: dict[str, Any] = json.loads(out.read_text(encoding="utf-8"))["native"]
    return section


def test_contenders_agree(measured: dict[str, Any]) -> None:
    assert [job["name"] for job in measured["jobs"]] == ["J1", "J2", "J3", "J4", "J5"]
    for job in measured["jobs"]:
        by_hand = "C scalar" if job["name"] in {"J4", "J5"} else "numba by hand"
        assert {entry["name"] for entry in job["entries"]} >= {"hydroservo", by_hand}
        differences = {entry["name"]: entry["difference"] for entry in job["entries"]}
        assert {name: d for name, d in differences.items() if not d <= TOLERANCE} == {}


def test_tables_hold_every_contender(measured: dict[str, Any]) -> None:
    header, rows = summary(measured)
    assert len(header) == 1 + len(measured["jobs"])
    for column, job in enumerate(measured["jobs"], 1):
        shown = {row[0] for row in rows if row[column]}
        assert shown == {entry["name"] for entry in job["entries"]}
        assert len(job_table(job)[1]) == len(job["entries"])


def test_missing_peers_are_named() -> None:
    """Without a compiler on the path there is no C."""
    done = run("--jobs", "J2", "--peers", "hydroservo,C scalar", path="")
    assert "Left out: C scalar (there is no gcc)." in done.stdout
    assert "hydroservo" in done.stdout


def test_another_algorithm_gets_no_ratio(measured: dict[str, Any]) -> None:
    job = json.loads(json.dumps(measured["jobs"][1]))
    job["entries"][-1]["difference"] = 1e-3
    assert summary({"jobs": [job]})[1][-1][1].endswith("(-)")
    assert "not the same result" in " ".join(job_table(job)[1][-1])


def test_difference_is_relative_and_sees_what_is_not_a_number() -> None:
    one = {"a": np.array([1.0, 0.0]), "b": np.array([5.0])}
    assert difference(one, {"a": np.array([2.0, 0.0])}) == 0.5
    assert np.isnan(difference({"a": np.array([np.nan, 0.0])}, one))
    assert np.isnan(difference(one, {"c": np.array([1.0])}))


def test_each_machine_is_measured_and_shown(tmp_path: Path) -> None:
    out, wanted = tmp_path / "results.json", ["the paper's plant", "two chambers instead"]
    options = ["--only", ",".join(wanted), "--quick", "--rounds", "1", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "machines", *options],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert wanted[1] in done.stdout
    section = json.loads(out.read_text(encoding="utf-8"))["native"]
    header, rows = machines_table(section["machines"])
    assert len(header) == 2 + 2 * len(INTEGRATORS)
    assert [row[0] for row in rows] == wanted
    assert all(len(row) == len(header) and all(row) for row in rows)
    whole = {"machine": {"instructions": "some", "processor": "one"}, "jobs": []} | section
    assert any(wanted[1] in chapter for chapter in chapters(whole))


def test_the_machines_grow() -> None:
    from hydroservo.core.block import leaves
    from hydroservo.core.validation import checked

    states = [len(list(leaves(loop.machine(loop.init())))) for loop in map(checked, loops().values())]
    assert states == sorted(states)
    assert states[0] < states[-1]


@pytest.mark.parametrize("part", PARTS)
def test_each_part_can_be_left_out(part: str) -> None:
    assert in_process(part)["single"] > 0.0


def test_the_page_shows_the_results() -> None:
    shown = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    assert filled(shown, details(load())) == shown


def test_what_another_processor_took_stays_under_its_name(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    here, other = described(), described() | {"processor": "another"}
    save(file, {"native": {"machine": other, "jobs": [1]}})
    for count in (2, 3):
        keep(file, "native", {"machine": here, "jobs": [count]})
        found = {name: section["jobs"] for name, section in load(file).items()}
        assert found == {"native": [count], "native on another": [1]}
