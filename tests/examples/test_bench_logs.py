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


def test_friction_is_found_beside_what_else_is_in_the_force(bench):
    speeds, rng = np.array([0.01, 0.1, 0.5]), np.random.default_rng(0)
    true = bench.FrictionMap(speeds, np.array([200.0, 300, 900]), np.array([150.0, 180, 700]), [3.0, -2.0])
    velocity, besides = rng.uniform(-0.6, 0.6, 3000), rng.uniform(50.0, 90.0, (3000, 2))
    force = true.at(velocity) + besides @ true.besides + rng.normal(scale=5.0, size=3000)
    found = bench.friction_map(velocity, force, speeds, besides)
    for one, other in zip(found, true, strict=True):
        np.testing.assert_allclose(one, other, atol=4.0)
    np.testing.assert_array_equal(true.at([2.0, -2.0, 0.001]), [900.0, -700.0, 200.0])
    with pytest.raises(ValueError, match="says what friction says too"):
        bench.friction_map(velocity, force, speeds, np.ones((3000, 1)))
