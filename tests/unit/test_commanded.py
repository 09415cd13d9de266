"""Runs whose commands come from outside, held against runs of the law that gave these commands."""

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.runs.commanded import SteppedRuns
from hydroservo.testing.case import bits

CASES = {
    "rig/1khz-pi-square": {},
    "axis/position": {"reference.time": "20 ms"},  # a delayed command, an encoder, a steady start
    "axis/force": {"reference.time": "20 ms"},  # noise, whose seed is the run's
    "rig/noisy-1khz-tsmc-sine": {"simulation.integrator.type": "Tsit5"},
}
SHORT = {"simulation.duration": "0.1 s", "simulation.record_period": "1 ms"}
SEED = 12345


def played(runs: SteppedRuns, commands: np.ndarray, path: str) -> np.ndarray:
    """What all runs show at a path, sample by sample, under commands that are the same for all."""
    found = []
    for command in commands:
        found.append(runs[path].copy())
        runs.advance(np.full(len(found[0]), command))
    return np.array(found)


def begun(loop: hs.Loop, count: int, threads: int = 1) -> SteppedRuns:
    runs = SteppedRuns(loop, {}, count, threads=threads)
    every = np.arange(count)
    runs.begin(every, sets=0 * every, seeds=0 * every + SEED)
    return runs


@pytest.mark.parametrize("name", CASES)
def test_a_laws_commands_give_the_bits_of_its_run(name: str) -> None:
    loop = hs.load_scenario(name, {**SHORT, **CASES[name], "simulation.seed": SEED})
    data = hs.simulate(loop, strict=True)
    commands = data["controller.u"].to_numpy()
    for path in ("plant.velocity", "plant.position", "controlled.value"):
        ours = played(begun(loop, 1), commands, path)
        assert bits(ours[:, 0]) == bits(data[path].to_numpy()), path


def test_neither_neighbours_nor_threads_change_a_run() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square", SHORT)
    commands = np.linspace(0.0, 0.1, 20)
    alone = played(begun(loop, 1), commands, "plant.velocity")
    for count, threads in ((33, 1), (300, 2)):
        together = played(begun(loop, count, threads), commands, "plant.velocity")
        assert bits(together) == bits(np.repeat(alone, count, axis=1))


def test_runs_begin_anew_each_by_itself_with_their_own_parameters() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square", SHORT)
    runs = SteppedRuns(loop, {"plant.mass": [5.0, 8.0]}, 40, threads=1)
    every = np.arange(40)
    runs.begin(every, sets=every % 2, seeds=every)
    first = played(runs, np.full(10, 0.1), "plant.velocity")
    runs.begin(np.array([35]), sets=np.array([0]), seeds=np.array([0]))
    again = played(runs, np.full(10, 0.1), "plant.velocity")
    assert bits(again[:, 35]) == bits(first[:, 0])
    assert bits(first[:, 0]) != bits(first[:, 1])
    alone = hs.simulate(hs.replace(runs.loop_of(1, 0), {"controller.proportional_gain": 0.0}), strict=True)
    assert alone.attrs["seed"] == 0
    assert runs.loop_of(1, 0).plant.mass == 8.0


def test_a_run_that_diverges_says_so_and_leaves_its_neighbours() -> None:
    loop = hs.load_scenario("paper/sine-pi", {**SHORT, "simulation.period": "1 ms"})
    loop = hs.replace(loop, {"simulation.substeps": 1})
    with pytest.warns(hs.HydroservoWarning, match="too coarse"):
        runs = SteppedRuns(loop, {"plant.bulk_modulus": [7e8, 7e13]}, 2)
    both = np.arange(2)
    runs.begin(both, sets=both, seeds=both)
    for _ in range(50):
        runs.advance(np.full(2, 0.01))
    assert runs.lost.tolist() == [False, True]
    assert np.isfinite(runs["plant.velocity"][0])
    runs.begin(both[1:], sets=np.zeros(1, dtype=int), seeds=both[1:])
    assert not runs.lost.any()


def test_what_cannot_run_is_refused_in_one_line() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square", SHORT)
    with pytest.raises(hs.ParameterError, match="plant"):
        SteppedRuns(loop, {"plant.mass": [-1.0]}, 1)
    with pytest.raises(hs.ParameterError, match="threads"):
        SteppedRuns(loop, {}, 1, threads=0)


@pytest.mark.parametrize(
    ("which", "sets", "seeds"),
    [
        ([2], [0], [1]),
        ([-1], [0], [1]),
        ([0], [1], [1]),
        ([0], [0], [-1]),
        ([0, 1], [0], [1]),
        ([0.5], [0], [1]),
    ],
)
def test_runs_that_are_none_are_refused(which: list[float], sets: list[int], seeds: list[int]) -> None:
    runs = begun(hs.load_scenario("rig/1khz-pi-square", SHORT), 2)
    with pytest.raises(hs.ParameterError, match="whole numbers from 0 to"):
        runs.begin(np.array(which), np.array(sets), np.array(seeds))


@pytest.mark.parametrize("commands", [[0.0], [0.0, 1.0, 2.0], [0.0, np.nan], [np.inf, 0.0]])
def test_commands_that_are_none_are_refused(commands: list[float]) -> None:
    runs = begun(hs.load_scenario("rig/1khz-pi-square", SHORT), 2)
    with pytest.raises(hs.ParameterError, match="must be 2 finite numbers"):
        runs.advance(np.array(commands))


def test_what_is_shown_stays_when_runs_go_on() -> None:
    runs = begun(hs.load_scenario("rig/1khz-pi-square", SHORT), 2)
    before = runs["plant.velocity"]
    kept = before.copy()
    for _ in range(20):
        runs.advance(np.array([1.0, 1.0]))
    assert (before == kept).all()
    assert (runs["plant.velocity"] != kept).all()
