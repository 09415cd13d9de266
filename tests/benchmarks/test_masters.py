"""The table of masters shows what was measured, and what is measured here is in it."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.masters import ALL
from benchmarks.masters.master import Master
from benchmarks.masters.measure import RESULTS, Systems, exported_systems, measured, updated
from benchmarks.masters.system import SAMPLES, System, delayed, error, simulated, undelayed
from benchmarks.masters.table import page
from benchmarks.results import load
from hydroservo.export.fmu import FmiVersion
from tests.support.needs import needs

pytestmark = pytest.mark.nightly

PAGE = Path(__file__).parents[2] / "docs" / "export.md"
EXACT = ("by hand: in order", "by hand: unit by unit", "FMPy: loop as one FMU", "FMPy container_fmu")
EXACT += ("fmucontainer -sequential", "OMSimulator")


@pytest.fixture(scope="module")
def systems(tmp_path_factory: pytest.TempPathFactory) -> Systems:
    needs("cc")
    return exported_systems(tmp_path_factory.mktemp("systems"))


def test_the_page_shows_the_results() -> None:
    assert page(load(RESULTS)) in PAGE.read_text(encoding="utf-8"), "run python -m benchmarks masters"


def test_masters_that_keep_the_order_run_the_loop_as_it_is_simulated() -> None:
    results = load(RESULTS)
    assert set(results) == {one.name for one in ALL}
    assert {name for name, one in results.items() if one["equal"] == SAMPLES} == set(EXACT)
    for name in EXACT:
        assert results[name]["error"] == pytest.approx(error(simulated(undelayed())), rel=1e-12)


def test_gains_for_the_delay_serve_what_comes_late() -> None:
    late = error(simulated(delayed()))
    for name, one in load(RESULTS).items():
        if one["error"] > 1e-3:
            assert one["error_with_gains_for_delay"] == pytest.approx(late, rel=0.01), name


@pytest.mark.parametrize("master", ALL, ids=lambda master: master.name)
def test_it_does_what_the_page_says(master: Master, systems: Systems) -> None:
    stored = load(RESULTS)[master.name]
    if master.version() is None:
        pytest.skip(f"missing: {master.package}")
    found = measured(master, systems, lambda _: None)
    assert found["equal"] == stored["equal"]
    for key in ("error", "error_with_gains_for_delay"):
        assert found[key] == pytest.approx(stored[key], rel=1e-9)


def refused(system: System) -> list[float]:
    if system.version is FmiVersion.FMI3:
        raise RuntimeError("not that version")
    return [0.0] * SAMPLES


def late(system: System) -> list[float]:
    raise RuntimeError("a step failed")


def test_what_cannot_be_measured_keeps_its_result(systems: Systems) -> None:
    said: list[str] = []
    masters = [
        Master("old", "fmpy", "", refused),
        Master("failing", "fmpy", "", late),
        Master("missing", "no-such-master", "", refused),
    ]
    before = {name: {"equal": -1} for name in ("failing", "missing")}
    found = updated(before, masters, systems, said.append)
    assert found["failing"] == before["failing"]
    assert found["missing"] == before["missing"]
    assert found["old"]["fmi"] == ["2"]
    assert found["old"]["error"] == pytest.approx(error(np.zeros(SAMPLES)))
    assert said == [
        "old",
        "old, FMI 3: not that version",
        "failing",
        "failing: a step failed; its last result is kept",
        "missing: no-such-master is not installed; its last result is kept",
    ]
