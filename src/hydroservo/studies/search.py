"""One search of a law's gains in one cell: its front of error and command activity, and its judgement."""

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import field_at
from hydroservo.core.errors import HydroservoError
from hydroservo.core.validation import within
from hydroservo.runs.tuning import CANDIDATES, SearchSpace, latin_hypercube
from hydroservo.studies.conditions import (
    LOST,
    ActivityWindow,
    ConditionGroup,
    Evaluation,
    Points,
    SearchTask,
    evaluate,
    mean_logs,
)
from hydroservo.studies.fronts import STILL, evenly_spaced, fittest, front_shift, offspring, on_front
from hydroservo.studies.trials import Rules

if TYPE_CHECKING:
    import pyarrow as pa

Numbers = NDArray[np.float64]

TIE = float(np.log(Rules().margin))  # between errors of points that are worth the same
DECADE = 10.0  # by which a range is widened
EDGE = 0.01  # of a range, that is its end
FIRST = 256  # candidates after which a front is looked at for the first time
POINTS = 32  # of a front, that are judged
COLUMNS = {  # of the table of a search
    "law": "string",
    "cell": "string",
    "search_seed": "int64",
    "point": "int64",
    "candidates": "int64",
    "moved": "float64",
    "split": "string",
    "condition": "int64",
    "scale": "float64",
    "error": "float64",
    "activity": "float64",
    "swing": "float64",
    "lost": "bool_",
    "parameters": "string",
}


class LawSearch(NamedTuple):
    """What a search came to."""

    space: SearchSpace  # the ranges, as wide as they are at its end
    values: Numbers  # all points that were tried, shape (points, paths), in SI units
    costs: Numbers  # logarithms of their error and activity, shape (points, 2)
    window: ActivityWindow  # the activities that count
    moved: float  # how far the last half of the candidates moved the front, by :func:`~.pareto.front_shift`


def search_table(task: SearchTask) -> "pa.Table":
    """The rows of one search: the points of its front under each condition.

    All are judged on train and validation, those that are on the front of validation on the other splits.
    """
    found = search_front(task)
    members = evenly_spaced(within_window(found.costs, found.window), POINTS)
    rounded = [found.space.rounded(unit) for unit in found.space.units(found.values[members])]
    points = list({json.dumps(one): one for one in rounded}.values())
    seen = {split: evaluate(task, point_columns(points), split) for split in ("train", "validation")}
    kept = np.flatnonzero(may_be_chosen(seen["validation"]))
    for split in splits_of(task.groups):
        if split not in seen:
            seen[split] = evaluate(task, point_columns([points[k] for k in kept]), split)
    return search_rows(task, found, points, kept, seen)


def may_be_chosen(validation: Evaluation) -> NDArray[np.bool_]:
    """Whether each point is the best at some activity: no calmer one loses fewer runs or has less error.

    A lost run counts against the error alone, for a point that loses some may be the only one so calm.
    """
    return on_front(mean_logs(validation, LOST, 0.0))


def point_columns(points: Sequence[Mapping[str, float]]) -> dict[str, Numbers]:
    return {path: np.array([one[path] for one in points]) for path in points[0]}


def search_front(task: SearchTask) -> LawSearch:
    """The points that a search tries, by twice as many each time until its front is still."""
    random = np.random.default_rng([task.seed, 1])
    space, widened_by = SearchSpace(task.ranges), 0
    window = task.window or (-np.inf, np.inf)
    units = latin_hypercube(CANDIDATES, len(space.ranges), task.seed)
    values = value_matrix(space, units)
    costs = training_costs(task, space.values(units))
    population, moved = np.arange(CANDIDATES), np.inf
    while len(values) < task.candidates:
        units = offspring(space.units(values[population]), within_window(costs[population], window), random)
        values = np.concatenate([values, value_matrix(space, units)])
        costs = np.concatenate([costs, training_costs(task, space.values(units))])
        young = np.arange(len(values) - CANDIDATES, len(values))
        both = np.concatenate([population, young])
        population = both[fittest(within_window(costs[both], window), CANDIDATES)]
        count = len(values)
        if count < FIRST or count & (count - 1):
            continue
        if not np.isfinite(costs).any():
            raise HydroservoError(f"{task.law} in {task.cell}: no candidate makes a valid controller")
        window = task.window or own_window(costs, task.calmest)
        now = within_window(costs, window)
        moved = front_shift(within_window(costs[: count // 2], window), now[evenly_spaced(now, POINTS)])
        may = widened_by < task.widen and count < task.candidates
        wider = widen_ranges(task, space, values[on_front(now)]) if may else space
        if wider.ranges != space.ranges:
            space, widened_by = wider, widened_by + 1
        elif moved < STILL and count > FIRST:
            break
    return LawSearch(space, values, costs, window, moved)


def value_matrix(space: SearchSpace, units: Numbers) -> Numbers:
    """The values of points of the unit cube, shape (points, paths)."""
    return np.stack(list(space.values(units).values()), axis=1)


def within_window(costs: Numbers, window: ActivityWindow) -> Numbers:
    """Costs as a search compares them: calm alike below a window, and lost beyond it; all finite."""
    low, high = window
    error, activity = np.minimum(costs, 1e300).T
    beyond = np.maximum(activity - high, 0.0)
    worse = np.where(beyond > 0.0, LOST + np.minimum(beyond, LOST), 0.0)
    return np.stack([error + worse, np.maximum(activity, low)], axis=1)


def own_window(costs: Numbers, calmest: float) -> ActivityWindow:
    """The activities that count of the law that others are held against: up to its own, and beyond."""
    return float(np.log(calmest)) + activity_of(costs), np.inf


def activity_of(costs: Numbers) -> float:
    """The logarithm of the activity of the calmest point that ties with the one of the least error."""
    error, activity = costs.T
    return float(activity[error <= error.min() + TIE].min())


def widen_ranges(task: SearchTask, space: SearchSpace, front: Numbers) -> SearchSpace:
    """Ranges that go a decade further where a point of the front is at an end, and numbers may go there."""
    found = dict(space.ranges)
    loop = task.groups[0].loop
    for (path, (low, high)), own in zip(space.ranges.items(), space.units(front).T, strict=True):
        field = field_at(loop, path)
        down = own.min() <= EDGE and low > 0.0 and within(low / DECADE, field)
        up = own.max() >= 1.0 - EDGE and high > 0.0 and within(high * DECADE, field)
        found[path] = low / DECADE if down else low, high * DECADE if up else high
    return SearchSpace(found)


def training_costs(task: SearchTask, points: Points) -> Numbers:
    """The two costs of points on the training conditions, shape (points, 2)."""
    return mean_logs(evaluate(task, points, "train"), LOST, LOST)


def search_rows(
    task: SearchTask,
    found: LawSearch,
    points: Sequence[Mapping[str, float]],
    kept: NDArray[np.int64],
    judgements: Mapping[str, Evaluation],
) -> "pa.Table":
    """The rows of a search: split by split, point by point, condition by condition."""
    import pyarrow as pa

    schema = pa.schema([(name, getattr(pa, kind)()) for name, kind in COLUMNS.items()])
    tables = []
    for split in splits_of(task.groups):
        own, (numbers, scales) = judgements[split], condition_arrays(task.groups, split)
        order = np.argsort(numbers)
        whole = split in ("train", "validation")
        for row, point in enumerate(range(len(points)) if whole else kept.tolist()):
            error = np.where(np.isnan(own.error[row]), np.inf, own.error[row])
            of_runs = {
                "condition": numbers,
                "scale": scales,
                "error": error,
                "activity": own.activity[row],
                "swing": own.swing[row],
                "lost": np.isinf(error),
            }
            of_all = {
                "law": task.law,
                "cell": task.cell,
                "search_seed": task.seed,
                "point": point,
                "candidates": len(found.values),
                "moved": found.moved,
                "split": split,
                "parameters": json.dumps(points[point]),
            }
            rows = {name: column[order] for name, column in of_runs.items()}
            rows |= {name: [value] * order.size for name, value in of_all.items()}
            tables.append(pa.table(rows, schema=schema))
    return pa.concat_tables(tables).combine_chunks()


def splits_of(groups: Sequence[ConditionGroup]) -> list[str]:
    return list(dict.fromkeys(split for group in groups for split in group.drawn))


def condition_arrays(groups: Sequence[ConditionGroup], split: str) -> tuple[NDArray[np.int64], Numbers]:
    """The numbers of a split's conditions, and their scales, in the order of the groups."""
    own = [group.drawn[split] for group in groups if split in group.drawn]
    return np.concatenate([one.numbers for one in own]), np.concatenate([one.scales for one in own])
