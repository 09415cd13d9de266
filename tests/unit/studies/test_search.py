"""One search of a law's front: its ranges, its window, its points, and what it refuses."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from hydroservo import HydroservoError, load_scenario, simulate_batch
from hydroservo.core.block import replace
from hydroservo.runs.tuning import SearchSpace
from hydroservo.studies import conditions
from hydroservo.studies import search as searching
from hydroservo.studies.cells import laws_in_cells, with_search_steps
from hydroservo.studies.conditions import (
    LOST,
    ConditionGroup,
    Evaluation,
    SearchTask,
    command_range,
    mean_logs,
)
from hydroservo.studies.fronts import STILL, on_front
from hydroservo.studies.search import (
    POINTS,
    may_be_chosen,
    own_window,
    search_front,
    search_table,
    widen_ranges,
    within_window,
)
from hydroservo.studies.spec_file import read_study

GAIN = "controller.proportional_gain"
INTEGRAL = "controller.integral_gain"
RANGE = {GAIN: (0.03, 30.0)}
SHORT = {
    "set.simulation.duration": "0.2 s",
    "conditions.train": 2,
    "conditions.validation": 4,
    "conditions.test": 4,
    "conditions.stressed": 2,
}


@pytest.fixture(scope="module")
def task() -> SearchTask:
    """A search of the PI's in the study small, cut short."""
    entrant = next(laws_in_cells(read_study("small", SHORT)))
    groups = [
        ConditionGroup(
            one.loop,
            with_search_steps(one.loop, 0.25e-3),
            {split: own[kind] for split, own in entrant.drawn.items() if kind in own},
        )
        for kind, one in entrant.contender.assemblies.items()
    ]
    return SearchTask("pi", "low", 0, "rms_error", 256, 1, 0.4, None, entrant.contender.ranges, groups)


def with_best_at(monkeypatch: pytest.MonkeyPatch, gain: float) -> None:
    """Have the error known: it is least at a gain, and the activity is as large as the gain."""

    def cost(_: SearchTask, points: Mapping[str, np.ndarray]) -> np.ndarray:
        return np.stack([np.log(points[GAIN] / gain) ** 2, np.log(points[GAIN])], axis=1)

    monkeypatch.setattr(searching, "training_costs", cost)


def test_a_best_value_inside_is_found_and_no_range_widened(
    task: SearchTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_best_at(monkeypatch, 2.0)
    found = search_front(task._replace(ranges=RANGE, candidates=1024, widen=3))
    assert found.space.ranges == RANGE
    assert found.values[found.costs[:, 0].argmin(), 0] == pytest.approx(2.0, rel=1e-2)


@pytest.mark.parametrize(
    ("best", "widen", "ends"),
    [
        (100.0, 1, (0.03, 300.0)),
        (100.0, 0, (0.03, 30.0)),
        (1e6, 2, (0.03, 3000.0)),
        (1e-3, 2, (0.0003, 30.0)),
    ],
)
def test_a_range_at_whose_end_the_front_lies_is_a_decade_wider(
    task: SearchTask, monkeypatch: pytest.MonkeyPatch, best: float, widen: int, ends: tuple[float, float]
) -> None:
    with_best_at(monkeypatch, best)
    found = search_front(task._replace(ranges=RANGE, widen=widen, candidates=4096))
    assert found.space.ranges[GAIN] == pytest.approx(ends)
    reached = found.values[found.costs[:, 0].argmin(), 0]
    assert reached == pytest.approx(min(max(best, ends[0]), ends[1]), rel=0.05)


def test_a_search_ends_when_its_front_is_still(task: SearchTask, monkeypatch: pytest.MonkeyPatch) -> None:
    with_best_at(monkeypatch, 2.0)
    found = search_front(task._replace(ranges=RANGE, candidates=65_536))
    assert len(found.values) < 4096
    assert found.moved < STILL


def test_a_range_stays_where_its_number_may_be(task: SearchTask) -> None:
    """An exponent may be from 0.1 to below 1."""
    path = "controller.controller.error_dynamics.exponent_1"
    groups = [one._replace(loop=load_scenario("laws/fast-terminal-sine")) for one in task.groups]
    terminal, space = task._replace(groups=groups), SearchSpace({path: (0.2, 0.9)})
    assert widen_ranges(terminal, space, np.array([[0.2], [0.9]])).ranges == space.ranges


def test_an_end_at_zero_has_no_decade_below(task: SearchTask) -> None:
    space = SearchSpace({GAIN: (0.0, 3.0)})
    assert widen_ranges(task, space, np.array([[0.0]])).ranges == {GAIN: (0.0, 3.0)}
    assert widen_ranges(task, space, np.array([[0.0], [3.0]])).ranges == {GAIN: (0.0, 30.0)}


def test_units_are_where_values_come_from() -> None:
    space = SearchSpace({GAIN: (0.03, 30.0), INTEGRAL: (0.0, 5.0)})
    units = np.random.default_rng(0).random((9, 2))
    values = np.stack(list(space.values(units).values()), axis=1)
    assert space.units(values) == pytest.approx(units)


def test_a_search_is_the_same_each_time_and_its_points_are_judged(task: SearchTask) -> None:
    first, again = search_table(task).to_pandas(), search_table(task).to_pandas()
    assert first.equals(again)
    sizes = first.groupby("split")["point"].nunique()
    assert sizes["train"] == sizes["validation"] <= POINTS
    assert 0 < sizes["test"] == sizes["stress"] <= sizes["validation"]
    assert (first.groupby(["split", "point"])["condition"].count().unstack("split").max() == [8, 4, 2, 4])[
        ["stress", "test", "train", "validation"]
    ].all()
    assert first[first["split"] == "test"]["swing"].notna().any()
    validation = first[first["split"] == "validation"].groupby("point")
    costs = np.stack(
        [
            np.log(validation["error"].agg(list).tolist()).mean(axis=1),
            np.log(validation["activity"].agg(list).tolist()).mean(axis=1),
        ],
        axis=1,
    )
    assert set(np.flatnonzero(on_front(costs))) == set(first[first["split"] == "test"]["point"])


def test_the_search_is_coarse_and_its_judgement_is_not(task: SearchTask) -> None:
    group = task.groups[0]
    assert (group.loop.simulation.substeps, group.coarse.simulation.substeps) == (10, 4)
    assert with_search_steps(group.loop, None) == group.loop
    assert with_search_steps(group.loop, 1e-9) == group.loop  # never finer than it is judged


def test_a_window_ends_what_counts() -> None:
    costs = np.log([[3.0, 0.1], [2.0, 0.2], [1.0, 1.0], [0.5, 9.0]])
    seen = within_window(costs, (math.log(0.4), math.log(2.0)))
    assert seen[:2, 1] == pytest.approx(math.log(0.4))
    assert on_front(seen).tolist() == [False, True, True, False]
    assert seen[3, 0] > LOST


def test_the_references_window_begins_below_its_own_activity() -> None:
    costs = np.log([[3.0, 0.1], [1.04, 1.0], [1.0, 4.0]])
    assert own_window(costs, 0.4) == (pytest.approx(math.log(0.4)), math.inf)


def test_a_metric_that_is_nan_is_refused(task: SearchTask, monkeypatch: pytest.MonkeyPatch) -> None:
    def runs(*arguments: Any, **named: Any) -> Any:
        return simulate_batch(*arguments, **named).assign(rms_error=lambda one: np.nan * one.rms_error)

    monkeypatch.setattr(conditions, "simulate_batch", runs)
    with pytest.raises(HydroservoError, match="is nan in runs that were not lost"):
        search_table(task)


def test_a_search_in_which_nothing_is_possible_is_refused(
    task: SearchTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        searching, "training_costs", lambda _, points: np.full((points[GAIN].size, 2), np.inf)
    )
    with pytest.raises(HydroservoError, match="pi in low: no candidate makes a valid controller"):
        search_table(task)


def test_a_lost_run_costs_more_than_any_other() -> None:
    """However small the errors of the others, and however calm their commands."""

    def of(error: list[float], activity: list[float]) -> np.ndarray:
        swing = np.zeros((1, len(error)))
        return mean_logs(Evaluation(np.array([error]), np.array([activity]), swing), LOST, LOST)[0]

    assert (of([np.inf, 1e-9], [np.nan, 1e-9]) > of([1e9, 1e9], [1e6, 1e6])).all()
    assert (of([np.inf, np.inf], [0.0, 0.0]) > of([np.inf, 1.0], [0.0, 1.0])).all()
    assert (of([np.nan, 1.0], [np.nan, 1.0]) == np.inf).all()
    assert np.isfinite(of([0.0, 1.0], [0.0, 1.0])).all()
    assert of([1.0, 4.0], [1.0, 9.0]) == pytest.approx(np.log([2.0, 3.0]))


def test_a_calm_point_that_loses_a_run_may_be_chosen() -> None:
    """For where only it is so calm, it is compared, though a livelier one loses none."""
    error = np.array([[np.inf, 2.0], [1.0, 1.0], [1.0, 3.0]])
    activity = np.array([[np.nan, 1.0], [2.0, 2.0], [2.0, 2.0]])
    assert may_be_chosen(Evaluation(error, activity, 0.0 * activity)).tolist() == [True, True, False]


def test_the_commands_range_is_that_of_the_outermost_limiter() -> None:
    loop = load_scenario("axis/position")
    outer = replace(loop, {"controller.controller.saturation.limit": 4.0})
    assert (command_range(loop), command_range(outer)) == (20.0, 8.0)
