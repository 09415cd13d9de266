"""A run of a batch over seeds is the single run with its seed, whatever runs beside it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.metrics import declared_metrics, monitors_of
from hydroservo.machine.sensors import NoisySensors
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from hydroservo.testing.examples import example

LOOP = example(
    Loop,
    Simulation(0.02, 1e-4, 1),
    valve=example(FirstOrderValve),
    sensors=example(NoisySensors),
    controller=PI(3.0, 300.0),
)


@settings(max_examples=4)
@given(first=st.integers(0, 2**53 - 80), runs=st.integers(1, 70))
def test_each_run_has_the_bits_of_its_single_run(first: int, runs: int) -> None:
    seeds = first + np.arange(runs)
    table = simulate_batch(LOOP, {"simulation.seed": seeds}, strict=True)
    assert table["simulation.seed"].values.tolist() == seeds.tolist()
    for run in (0, runs // 2, runs - 1):
        single = simulate(replace(LOOP, {"simulation.seed": int(seeds[run])}), record=[], strict=True)
        for name in declared_metrics(monitors_of(LOOP)):
            assert (
                table[name][run].values.tobytes() == single[name].values.astype(table[name].dtype).tobytes()
            )


@settings(max_examples=8)
@given(runs=st.integers(1, 100), chunk=st.integers(1, 300), threads=st.integers(1, 5))
def test_chunks_threads_and_neighbours_do_not_matter(runs: int, chunk: int, threads: int) -> None:
    seeds = np.arange(runs)
    whole = simulate_batch(LOOP, {"simulation.seed": seeds}, threads=1)
    part = slice(runs // 3, runs // 3 + runs // 2 + 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch, "CHUNK", chunk)
        cut = simulate_batch(LOOP, {"simulation.seed": seeds[part]}, threads=threads)
    assert cut.identical(whole.isel(run=part))


def test_every_seed_gives_another_run() -> None:
    table = simulate_batch(LOOP, {"simulation.seed": np.arange(64)})
    assert np.unique(table["rms_error"]).size == 64
