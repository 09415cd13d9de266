"""The table of laws and observers is what its script makes of what it found."""

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from runpy import run_path
from typing import Any

import pytest

import hydroservo as hs

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "factorial"
FOUND = ROOT / "docs" / "_static" / "factorial.json"
PAGE = ROOT / "docs" / "controllers" / "factorial.md"


@pytest.fixture
def factorial(monkeypatch: pytest.MonkeyPatch) -> Mapping[str, Any]:
    monkeypatch.syspath_prepend(SCRIPT.parent)
    return run_path(str(SCRIPT))


def test_the_tables_of_the_page_are_what_the_file_holds(factorial: Mapping[str, Any]) -> None:
    shown = factorial["texts"](json.loads(FOUND.read_text(encoding="utf-8")))
    page = PAGE.read_text(encoding="utf-8")
    for mark, text in shown.items():
        assert f"<!-- {mark}: begin -->\n{text}<!-- {mark}: end -->" in page


def test_a_factor_leaves_out_what_was_lost(factorial: Mapping[str, Any]) -> None:
    assert factorial["worst_over_best"]([2.0, 3.0, float("inf")]) == 1.5
    assert factorial["worst_over_best"]([float("inf")]) == 1.0


def test_a_rate_is_searched_as_far_as_the_samples_go(factorial: Mapping[str, Any]) -> None:
    """And nothing else: a share of the sample period and a time stay as they are."""
    cell = factorial["Cell"]("linear", "HighGainObserver", "", (), 64)
    slow, fast = (factorial["task"](cell, loop)[1] for loop in ("noisy-1khz", "noisy-10khz"))
    further = {path for path in slow if fast[path] != slow[path]}
    dynamics, observer = "controller.controller.error_dynamics.", "controller.controller.observer."
    assert further == {
        f"{dynamics}first_pole",
        f"{dynamics}second_pole",
        f"{observer}velocity_rate",
        f"{observer}hydraulic_force_rate",
    }
    assert {fast[path][1] / slow[path][1] for path in further} == {10.0}


@pytest.mark.parametrize(
    ("part", "outer"),
    [("", "ValveInversion"), ("ValveInversion", "Inverting"), ("the demand's rates", "WithoutRates")],
)
def test_a_part_is_left_out_and_what_is_left_is_searched(
    factorial: Mapping[str, Any], part: str, outer: str
) -> None:
    cell = factorial["Cell"]("fast-terminal", "KalmanObserver", part, (), 64)
    changes, ranges = factorial["task"](cell, "noisy-1khz")
    loop = hs.load_scenario("laws/fast-terminal-sine", changes, [factorial["PLUGIN"]])
    assert type(loop.controller).__name__ == outer
    hs.replace(loop, {path: low for path, (low, _) in ranges.items()})  # all are there
    assert len(ranges) == (7 if part == "ValveInversion" else 8)


def test_a_law_without_terminal_powers_is_one_with_two_poles(factorial: Mapping[str, Any]) -> None:
    cell = factorial["Cell"]("fast-terminal", "KalmanObserver", "terminal powers", (), 64)
    changes, ranges = factorial["task"](cell, "noisy-1khz")
    dynamics = hs.load_scenario("laws/fast-terminal-sine", changes).controller.controller.error_dynamics
    assert (dynamics.power_gain_1, dynamics.power_gain_2) == (0.0, 0.0)
    assert [path for path in ranges if "power" in path] == []


def test_a_part_does_not_take_the_place_of_the_whole() -> None:
    before = FOUND.read_bytes()
    words = [sys.executable, str(SCRIPT), "--laws", "lq"]
    done = subprocess.run(words, stderr=subprocess.PIPE, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert "a part of it needs an --out of its own" in done.stderr
    assert FOUND.read_bytes() == before


@pytest.mark.nightly  # compiles what it searches
def test_the_command_searches_a_law_with_and_without_an_observer(tmp_path: Path) -> None:
    out = tmp_path / "found.json"
    words = ["--candidates", "64", "--loops", "noisy-1khz", "--laws", "linear"]
    words += ["--observers", "NoObserver", "KalmanObserver", "--out", str(out)]
    subprocess.run([sys.executable, str(SCRIPT), *words], check=True)
    cells = json.loads(out.read_text(encoding="utf-8"))["cells"]
    assert [(cell["law"], cell["observer"]) for cell in cells] == [
        ("linear", "NoObserver"),
        ("linear", "KalmanObserver"),
    ]
    alone, observed = (cell["searches"][0] for cell in cells)
    assert alone["sine"]["error"] > 2.0 * observed["sine"]["error"]  # the load's offset is left
    gains = observed["parameters"] | {"simulation.seed": 100}
    run = hs.simulate(hs.load_scenario("laws/linear-sine", gains), record=())
    assert float(run["rms_error"]) == pytest.approx(observed["sine"]["error"], rel=0.2)  # one of twenty seeds
