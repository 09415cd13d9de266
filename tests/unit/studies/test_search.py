"""One search of a law's gains: its ranges, its best points, and what it refuses."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from hydroservo import HydroservoError, load_scenario, simulate_batch
from hydroservo.block import replace
from hydroservo.runs.space import Space
from hydroservo.studies import search as searching
from hydroservo.studies.cells import entrants_of
from hydroservo.studies.file import read_study
from hydroservo.studies.search import Group, Task, command_range, edges_of, found_by, searched, widened

GAIN = "controller.proportional_gain"
RANGE = {GAIN: (0.03, 30.0)}
BARE = Task("", "", "de", 0, 0.1, "rms_error", 64, 0, {}, [])
SHORT = {
    "set.simulation.duration": "0.2 s",
    "conditions.train": 2,
    "conditions.validation": 2,
    "conditions.test": 2,
    "conditions.stressed": 2,
}


@pytest.fixture(scope="module")
def task() -> Task:
    """A search of the PI's in the study small, cut short."""
    entrant = next(entrants_of(read_study("small", SHORT)))
    groups = [
        Group(one.loop, {split: own[kind] for split, own in entrant.drawn.items() if kind in own})
        for kind, one in entrant.contender.assemblies.items()
    ]
    return Task("pi", "low", "de", 0, 0.1, "rms_error", 128, 1, entrant.contender.ranges, groups)


def with_best_at(monkeypatch: pytest.MonkeyPatch, gain: float) -> list[Mapping[str, tuple[float, float]]]:
    """Have the gain's best value known; the ranges that searches have are heard."""
    heard: list[Mapping[str, tuple[float, float]]] = []

    def cost(_: Task, points: Mapping[str, np.ndarray]) -> np.ndarray:
        return np.log(points[GAIN] / gain) ** 2

    def search(task: Task, space: Space) -> Sequence[searching.Best]:
        heard.append(space.ranges)
        return searched(task, space)

    monkeypatch.setattr(searching, "cost", cost)
    monkeypatch.setattr(searching, "searched", search)
    return heard


@pytest.mark.parametrize("optimiser", ["de", "cma"])
def test_a_best_value_inside_is_found_and_no_range_widened(
    task: Task, monkeypatch: pytest.MonkeyPatch, optimiser: str
) -> None:
    heard = with_best_at(monkeypatch, 2.0)
    table = found_by(task._replace(ranges=RANGE, optimiser=optimiser, candidates=1024, widen=3)).to_pandas()
    assert heard == [RANGE]
    found = [json.loads(one)[GAIN] for one in table.sort_values("budget")["parameters"]]
    assert found[-1] == pytest.approx(2.0, rel=1e-2)
    assert set(table[table["budget"] == 1024]["edges"]) == {"[]"}


@pytest.mark.parametrize(
    ("best", "widen", "ends"),
    [
        (100.0, 1, [(0.03, 30.0), (0.03, 300.0)]),
        (100.0, 0, [(0.03, 30.0)]),
        (1e6, 2, [(0.03, 30.0), (0.03, 300.0), (0.03, 3000.0)]),
        (1e-3, 2, [(0.03, 30.0), (0.003, 30.0), (0.0003, 30.0)]),
    ],
)
def test_a_range_at_whose_end_a_search_stopped_is_a_decade_wider(
    task: Task,
    monkeypatch: pytest.MonkeyPatch,
    best: float,
    widen: int,
    ends: list[tuple[float, float]],
) -> None:
    heard = with_best_at(monkeypatch, best)
    table = found_by(task._replace(ranges=RANGE, widen=widen, candidates=512)).to_pandas()
    assert [pytest.approx(one[GAIN]) for one in heard] == ends
    last = table[table["budget"] == 512]
    low, high = ends[-1]
    assert set(last["edges"]) == ({"[]"} if low < best < high else {f'["{GAIN}"]'})


def test_a_range_stays_where_its_number_may_be(task: Task) -> None:
    """An exponent may be from 0.1 to below 1."""
    path = "controller.controller.pull.exponent_1"
    groups = [one._replace(loop=load_scenario("laws/fast-terminal-sine")) for one in task.groups]
    terminal, ranges = task._replace(groups=groups), {path: (0.2, 0.9)}
    for end in (0.0, 1.0):
        assert widened(terminal, ranges, np.array([end])) == ranges


def test_an_end_at_zero_has_no_decade_below(task: Task) -> None:
    assert widened(task, {GAIN: (0.0, 3.0)}, np.array([0.0])) == {GAIN: (0.0, 3.0)}
    assert widened(task, {GAIN: (0.0, 3.0)}, np.array([1.0])) == {GAIN: (0.0, 30.0)}


@pytest.mark.parametrize(("unit", "edges"), [(0.005, [GAIN]), (0.5, []), (0.995, [GAIN])])
def test_edges_are_the_last_hundredths_of_a_range(unit: float, edges: list[str]) -> None:
    assert edges_of(Space(RANGE), np.array([unit])) == edges


@pytest.mark.parametrize("optimiser", ["de", "cma"])
def test_a_search_is_the_same_each_time_and_its_best_gets_no_worse(task: Task, optimiser: str) -> None:
    short = task._replace(optimiser=optimiser, widen=0)
    first, again = found_by(short).to_pandas(), found_by(short).to_pandas()
    assert first.equals(again)
    assert set(first["optimiser"]) == {optimiser}
    best = searched(short, Space(short.ranges))
    values = [Space(short.ranges).values(one.unit[np.newaxis]) for one in best]
    costs = [searching.cost(short, one)[0] for one in values]
    assert [one.budget for one in best] == [64, 128]
    assert costs[1] <= costs[0]


def test_a_metric_that_is_nan_is_refused(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    def runs(*arguments: Any, **named: Any) -> Any:
        return simulate_batch(*arguments, **named).assign(rms_error=lambda one: np.nan * one.rms_error)

    monkeypatch.setattr(searching, "simulate_batch", runs)
    with pytest.raises(HydroservoError, match="is nan in runs that were not lost"):
        found_by(task._replace(candidates=64))


def test_a_search_in_which_nothing_is_possible_is_refused(
    task: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(searching, "cost", lambda _, points: np.full(points[GAIN].size, np.inf))
    with pytest.raises(HydroservoError, match="pi in low: no candidate makes a valid controller"):
        found_by(task)


def test_a_lost_run_costs_more_than_any_other() -> None:
    """However small the errors of the others, and however calm their commands."""

    def of(error: list[float], activity: list[float]) -> float:
        judged = searching.Judged(np.array([error]), np.array([activity]))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(searching, "judged", lambda *_: judged)
            return float(searching.cost(BARE, {GAIN: np.ones(1)})[0])

    assert of([np.inf, 1e-9], [np.nan, 1e-9]) > of([1e9, 1e9], [1e6, 1e6])
    assert of([np.inf, np.inf], [0.0, 0.0]) > of([np.inf, 1.0], [0.0, 1.0])
    assert of([np.nan, 1.0], [np.nan, 1.0]) == np.inf
    assert of([0.0, 1.0], [0.0, 1.0]) > -np.inf


def test_the_commands_range_is_that_of_the_outermost_limiter() -> None:
    loop = load_scenario("axis/position")
    outer = replace(loop, {"controller.controller.saturation.limit": 4.0})
    assert (command_range(loop), command_range(outer)) == (20.0, 8.0)
