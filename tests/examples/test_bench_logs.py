"""What the page on a real bench says of its logs."""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def bench():
    sys.path.insert(0, str(ROOT / "scripts"))
    yield import_module("bench_logs")
    sys.path.remove(str(ROOT / "scripts"))


def test_the_licence_is_there():
    assert "Apache License" in (ROOT / "examples" / "bench" / "LICENSE").read_text(encoding="utf-8")


def test_one_log_has_a_pressure_with_the_other_sign(bench):
    raw = [bench.read(name) for name in ("friction_moves.csv", "waves.csv")]
    for log, other, same in zip(raw, bench.logs(), (True, False), strict=True):
        assert np.array_equal(log["lower"], other["lower"]) is same


def test_both_logs_give_the_published_displacement(bench):
    for log in bench.logs():
        assert bench.displacement(log) == pytest.approx(bench.PUBLISHED_DISPLACEMENT, rel=0.01)


def test_the_page_says_which_numbers_are_better_on_the_other_log(bench):
    moves, waves = bench.logs()
    here, there = bench.fitted(moves), bench.published(moves)
    assert bench.errors(here, moves)["force"] < bench.errors(there, moves)["force"]
    assert (
        bench.errors(there, waves)["force"]
        < bench.errors(here, waves)["force"]
        < 0.1 * np.std(waves["force"])
    )
    assert bench.errors(there, waves)["pressure"] < bench.errors(here, waves)["pressure"]
