"""The page on limits shows what its file holds, and no law there is below its limit."""

import json
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT, FOUND, PAGE = (
    ROOT / "scripts" / "limits",
    ROOT / "docs" / "_static" / "limits.json",
    ROOT / "docs" / "limit.md",
)
ENTRIES: list[dict[str, Any]] = json.loads(FOUND.read_text(encoding="utf-8"))


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Mapping[str, Any]:
    monkeypatch.syspath_prepend(SCRIPT.parent)
    return runpy.run_path(str(SCRIPT))


def test_the_table_of_the_page_is_what_the_file_holds(script: Mapping[str, Any]) -> None:
    assert script["text"](ENTRIES) in PAGE.read_text(encoding="utf-8")


def test_no_law_of_the_table_is_below_its_limit() -> None:
    for entry in ENTRIES:
        assert entry["clairvoyant"] < entry["law"], entry["scenario"]
        assert entry["clairvoyant"] <= entry["causal"], entry["scenario"]


def test_scenarios_of_one_task_share_their_limits(script: Mapping[str, Any]) -> None:
    task, load = script["task"], script["hs"].load_scenario
    assert task(load("rig/1khz-pi-square")) == task(load("rig/noisy-1khz-tsmc-square"))
    assert task(load("rig/1khz-pi-square")) != task(load("rig/10khz-pi-square"))
    assert task(load("rig/1khz-pi-square")) != task(load("rig/1khz-pi-sine"))
