"""Runs side by side give the bits of single runs, whatever the lanes, chunks and threads."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.metrics import declared_metrics, monitors_of
from hydroservo.control.observers import Implicit, TSMObserver
from hydroservo.control.references import Square
from hydroservo.control.wiring import wired
from hydroservo.machine.valves import FirstOrderValve, FourCurves, FourEdges, StaticValve
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from hydroservo.testing.examples import example
from tests.support.tiers import mostly

pytestmark = [  # each compiles lanes
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:valve.max_opening"),
]

LOOPS = {
    "tsmc": example(
        Loop,
        Simulation(0.02, 1e-4, 2),
        controller=example(TSMC, observer=example(TSMObserver, realisation=Implicit())),
    ),
    "pi": example(
        Loop,
        Simulation(0.02, 1e-4, 1),
        valve=example(FirstOrderValve),
        reference=example(Square),
        controller=example(PI),
    ),
    "notches": example(
        Loop,
        Simulation(0.02, 1e-4, 1),
        valve=example(StaticValve, orifice=example(FourEdges, shape=example(FourCurves), clearance=2e-6)),
        reference=example(Square),
        controller=example(PI),
    ),
}
RANGES = {
    "plant.bulk_modulus": (3e8, 2e9),
    "plant.start_position": (0.0, 0.078),
    "controller.saturation.limit": (1e-3, 10.0),
    "load.amplitude": (-500.0, 500.0),
}


def drawn(runs: int, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    return {path: rng.uniform(*limits, runs) for path, limits in RANGES.items()}


def same(a: float, b: float) -> bool:
    return a == b or (math.isnan(a) and math.isnan(b))


def assert_like_single_runs(loop: Loop, parameters: Mapping[str, Any], table: xr.Dataset) -> None:
    for run in range(table.sizes["run"]):
        own = replace(wired(loop), {path: float(values[run]) for path, values in parameters.items()})
        single = simulate(own, record=[], strict=True)
        for name in declared_metrics(monitors_of(loop)):
            assert same(float(table[name][run]), float(single[name])), (run, name)


@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LOOPS, ["tsmc"]))
@settings(max_examples=4)
@given(runs=st.integers(1, 70), seed=st.integers(0, 2**32 - 1))
def test_each_run_has_the_bits_of_its_single_run(name: str, runs: int, seed: int) -> None:
    parameters = drawn(runs, seed)
    assert_like_single_runs(LOOPS[name], parameters, simulate_batch(LOOPS[name], parameters, strict=True))


@given(
    runs=st.integers(1, 100),
    chunk=st.integers(1, 300),
    threads=st.integers(1, 5),
    strict=st.booleans(),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=24)
def test_chunks_threads_and_neighbours_do_not_matter(
    runs: int, chunk: int, threads: int, strict: bool, seed: int
) -> None:
    loop, parameters = LOOPS["tsmc"], drawn(runs, seed)
    whole = simulate_batch(loop, parameters, threads=1, strict=strict)
    part = slice(runs // 3, runs // 3 + runs // 2 + 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch, "CHUNK", chunk)
        cut = simulate_batch(
            loop, {p: v[part] for p, v in parameters.items()}, threads=threads, strict=strict
        )
    assert cut.identical(whole.isel(run=part))


def test_a_run_that_diverges_does_not_disturb_the_others() -> None:
    loop = LOOPS["pi"]._replace(valve=example(StaticValve, max_opening=1e300))
    gains = np.full(40, 100.0)
    gains[7] = 1e308
    parameters = {"controller.proportional_gain": gains, "controller.saturation.limit": np.full(40, 1e300)}
    table = simulate_batch(loop, parameters, strict=True)
    assert list(np.flatnonzero(table.diverged)) == [7]
    assert_like_single_runs(loop, parameters, table)
