"""A batch in parts has the rows of one table, bit for bit, whatever the parts and whoever computes them."""

import warnings

import numpy as np
import pytest

from hydroservo import HydroservoWarning, Loop, ParameterError, Simulation, simulate_batch
from hydroservo.cli.options import parse_ranges
from hydroservo.runs.columns import hardest_loop
from hydroservo.scenario import assemble
from hydroservo.scenario.parameter_draws import assembly_of_loop, variations
from hydroservo.scenario.ranges import as_entries
from hydroservo.scenario.stored_batch import SampledBatch, Workers, simulate_in_parts, table_of_runs
from hydroservo.testing.examples import example
from hydroservo.work.execution import UnitsError
from tests.support.tiers import mostly
from tests.support.work.units import contents

RUNS = 131
SHORT = {"simulation.duration": "5 ms"}
NOISY = {"type": "NoisySensors", "velocity_noise": "0.5 mm/s", "hydraulic_force_noise": "5 N"}
EDGES = {"type": "Orifice.rated", "rated_flow": "400 L/min", "rated_drop": "70 bar", "rated_opening": "5 mm"}
AUTO = {"simulation.duration": "20 ms", "simulation.period": "1 ms", "simulation.substeps": "auto"}
CASES = {
    "noise": ("paper/sine-backstepping", {**SHORT, "sensors": NOISY}, ["plant.mass=4..8kg"], True),
    "datasheet": (
        "paper/sine-pi",
        {**SHORT, "valve.orifice": EDGES},
        ["valve.orifice.rated_flow=-10%..+10%", "load.offset=-5..5 N"],
        False,
    ),
    "automatic substeps": ("paper/sine-pi", AUTO, ["plant.bulk_modulus=-50%..+50%"], False),
    "lost": ("paper/sine-pi", {**SHORT, "simulation.period": "1 ms"}, ["plant.mass=0.001..8kg"], False),
}


def sampled(case, strict=False):
    name, changes, ranges, seeds = CASES[case]
    assembly = assemble(name, changes)
    return SampledBatch(assembly, variations(assembly, parse_ranges(ranges)), 3, seeds, strict, cuda=False)


def in_one(one, runs=RUNS):
    """The table of all runs, in memory."""
    drawn = one.drawn(0, runs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HydroservoWarning)
        found = simulate_batch(one.assembly.loop, drawn.parameters, strict=one.strict)
    return table_of_runs(found, drawn, one.seed, one.assembly.arguments)


def assert_same_table(found, expected):
    assert list(found) == list(expected)
    assert found.attrs == expected.attrs
    for name in expected:
        np.testing.assert_array_equal(found[name].values, expected[name].values, err_msg=name)
        assert found[name].attrs == expected[name].attrs


@pytest.mark.slow
@pytest.mark.parametrize("case", mostly(pytest.mark.nightly, CASES, [*CASES][:1]))
def test_rows_have_the_bits_of_one_table_whatever_the_parts(tmp_path, case):
    one = sampled(case)
    expected = in_one(one)
    for size in (RUNS + 1, 64, 33):
        found = simulate_in_parts(one, RUNS, tmp_path / str(size), size=size)
        assert found.computed == RUNS
        assert_same_table(found.table, expected)
    if case == "lost":
        assert set(np.unique(expected["diverged"])) == {False, True}


@pytest.mark.slow
def test_processes_and_threads_come_to_the_same_bytes(tmp_path):
    one = sampled("noise")
    kinds = {"one": Workers(1, None, 1), "threads": Workers(1, None, 2), "processes": Workers(2, None, 1)}
    for name, workers in kinds.items():
        simulate_in_parts(one, RUNS, tmp_path / name, workers=workers, size=40)
    assert contents(tmp_path / "one") == contents(tmp_path / "threads") == contents(tmp_path / "processes")


@pytest.mark.nightly
def test_dask_comes_to_the_same_bytes(tmp_path):
    from tests.support.work.clusters import cluster

    with cluster(2) as found:
        for case in CASES:
            one, place = sampled(case), tmp_path / case
            simulate_in_parts(one, RUNS, place / "here", size=20)
            at = Workers(None, found.scheduler_address, 1)
            table = simulate_in_parts(one, RUNS, place / "there", workers=at, size=20).table
            assert contents(place / "here") == contents(place / "there")
            assert_same_table(table, in_one(one))


def test_more_runs_begin_alike_and_a_part_is_drawn_alone():
    one = sampled("noise")
    whole = one.drawn(0, 50)
    for first, runs in ((0, 1), (1, 7), (13, 30), (49, 1)):
        part = one.drawn(first, runs)
        for columns, all_of_them in (
            (part.parameters, whole.parameters),
            (part.deviations, whole.deviations),
        ):
            assert list(columns) == list(all_of_them)
            for path, column in columns.items():
                np.testing.assert_array_equal(column, all_of_them[path][first : first + runs])


def test_a_batch_goes_on_from_what_is_there(tmp_path):
    one = sampled("noise")
    simulate_in_parts(one, RUNS, tmp_path / "all", size=20)
    simulate_in_parts(one, RUNS, tmp_path / "some", size=20)
    lost = sorted((tmp_path / "some" / "parts").iterdir())[:2]
    for file in lost:
        file.unlink()
    found = simulate_in_parts(one, RUNS, tmp_path / "some", size=20)
    assert 20 < found.computed <= 40
    assert contents(tmp_path / "all") == contents(tmp_path / "some")
    assert simulate_in_parts(one, RUNS, tmp_path / "some", size=20).computed == 0


@pytest.mark.slow
def test_what_is_wrong_with_a_run_names_it_whatever_its_part(tmp_path):
    assembly = assembly_of_loop(example(Loop, Simulation(0.002, 1e-4)))
    varied = variations(assembly, as_entries({"plant.start_position": (0.05, 0.0785)}))
    one = SampledBatch(assembly, varied, 0, seeds=False, strict=False, cuda=False)
    with pytest.raises(ParameterError, match=r"must be at most the stroke, .*, in run \d+$") as expected:
        in_one(one)
    said = []
    with pytest.raises(UnitsError):
        simulate_in_parts(one, RUNS, tmp_path, size=5, say=said.append)
    assert any(line.endswith(f": {expected.value}") for line in said)


def test_the_hardest_run_is_the_same_in_parts():
    loop = example(Loop)
    draws = np.random.default_rng(1)
    for _ in range(20):
        columns = {path: draws.choice([0.5, 1.0, 2.0, 4.0], 12) for path in ("plant.mass", "plant.damping")}
        for size in (1, 5, 12):
            parts = [{p: v[i : i + size] for p, v in columns.items()} for i in range(0, 12, size)]
            assert hardest_loop(loop, parts) == hardest_loop(loop, [columns])


def test_a_number_that_is_the_loops_own_in_a_part_counts_there():
    loop = example(Loop)
    own = loop.plant.mass
    masses = np.array([own, own, 0.5 * own, own])
    other = np.array([1.0, 2.0, 3.0, 4.0])
    whole = {"plant.mass": masses, "plant.damping": other}
    parts = [
        {"plant.damping": other[:2]},
        {"plant.damping": other[2:], "plant.mass": masses[2:]},
    ]
    assert hardest_loop(loop, parts) == hardest_loop(loop, [whole])
