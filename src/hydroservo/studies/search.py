"""One search of a law's gains in one cell, and how what it found does under conditions not seen before."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import field_at, leaves
from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.loop import Loop
from hydroservo.runs.aims import ACTIVITY
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.objective import is_possible, needed
from hydroservo.runs.space import CANDIDATES, Space, minimum
from hydroservo.studies.conditions import Drawn
from hydroservo.studies.evolution import evolved
from hydroservo.validation import within

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Group", "Task", "command_range", "found_by"]

Numbers = NDArray[np.float64]
Points = Mapping[str, Numbers]  # arrays of shape (candidates,) by path

LOST = 60.0  # what a lost run adds to the mean logarithm: more than any metric and activity can differ by
TINIEST = 1e-300  # of errors: below it they are alike
CALMEST = 1e-6  # [% of the range a second] a command that varies less is not worth more
DECADE = 10.0  # by which a range is widened
COLUMNS = {  # of the table of a search
    "law": "string",
    "cell": "string",
    "optimiser": "string",
    "search_seed": "int64",
    "effort": "float64",
    "budget": "int64",
    "split": "string",
    "condition": "int64",
    "scale": "float64",
    "error": "float64",
    "activity": "float64",
    "lost": "bool_",
    "parameters": "string",
    "edges": "string",
}


class Group(NamedTuple):
    """The loop for one kind of condition, and the conditions of that kind by split."""

    loop: Loop
    drawn: Mapping[str, Drawn]


class Task(NamedTuple):
    """One search of a law's gains in one cell.

    Attributes:
        law: its name.
        cell: its name.
        optimiser: ``de`` or ``cma``.
        seed: of the search.
        effort: exponent of the command's activity in what is made small.
        metric: what is to be small.
        candidates: how many are tried; after each doubling from 64 on the best so far is judged.
        widen: how often the ranges may be widened at whose ends a search stopped.
        ranges: between what numbers are searched, in SI units, by path.
        groups: the loops and their conditions.
    """

    law: str
    cell: str
    optimiser: str
    seed: int
    effort: float
    metric: str
    candidates: int
    widen: int
    ranges: Mapping[str, tuple[float, float]]
    groups: Sequence[Group]


class Judged(NamedTuple):
    """How points do under conditions: arrays of shape (points, conditions)."""

    error: Numbers  # inf where a run was lost
    activity: Numbers  # total variation of the command in percent of its range a second


class Best(NamedTuple):
    """The best point of a search after a number of candidates."""

    budget: int
    unit: Numbers  # in the unit cube


def found_by(task: Task) -> "pa.Table":
    """The rows of one search: each budget's best point under each condition.

    Raises:
        HydroservoError: no candidate allowed a controller, a condition no machine, or the metric is nan in a
            run that was not lost.
    """
    ranges = dict(task.ranges)
    for again in range(task.widen + 1):
        space = Space(ranges)
        best = searched(task, space)
        if again == task.widen or not edges_of(space, best[-1].unit):
            break
        wider = widened(task, ranges, best[-1].unit)
        if wider == ranges:
            break
        ranges = wider
    points = [space.rounded(one.unit) for one in best]
    return table_of(task, [one.budget for one in best], points, [edges_of(space, one.unit) for one in best])


def edges_of(space: Space, unit: Numbers) -> list[str]:
    """The paths at an end of their range."""
    return [path for path, one in zip(space.ranges, unit, strict=True) if not 0.01 < one < 0.99]


def searched(task: Task, space: Space) -> list[Best]:
    """The best points after 64, 128, 256 ... candidates and after all.

    Raises:
        HydroservoError: no candidate allowed a controller.
    """
    generations = math.ceil(task.candidates / CANDIDATES)
    due = {2**k for k in range(generations.bit_length()) if 2**k <= generations} | {generations}
    kept: list[Best] = []
    best, at, count = math.inf, np.full(len(space.ranges), 0.5), 0

    def generation(units: Numbers) -> Numbers:
        nonlocal best, at, count
        found = cost(task, space.values(units.T))
        count += 1
        if found.min() < best:
            best, at = found.min(), units[:, found.argmin()].copy()
        if count in due:
            kept.append(Best(count * CANDIDATES, at))
        return found

    search = {"de": minimum, "cma": evolved}[task.optimiser]
    search(generation, len(space.ranges), generations, task.seed)
    if math.isinf(best):
        raise HydroservoError(f"{task.law} in {task.cell}: no candidate makes a valid controller")
    return kept


def widened(
    task: Task, ranges: Mapping[str, tuple[float, float]], unit: Numbers
) -> dict[str, tuple[float, float]]:
    """Ranges that go a decade further where a search stopped at an end, and their numbers may go there."""
    found = dict(ranges)
    loop = task.groups[0].loop
    for (path, (low, high)), one in zip(ranges.items(), unit, strict=True):
        field = field_at(loop, path)
        if one <= 0.01 and low > 0.0 and within(low / DECADE, field):
            found[path] = low / DECADE, high
        if one >= 0.99 and high > 0.0 and within(high * DECADE, field):
            found[path] = low, high * DECADE
    return found


def cost(task: Task, points: Points) -> Numbers:
    """What a search makes small: the mean over the training conditions of log(metric activity^effort).

    A lost run adds more than any other run can; a point that allows no controller is worse than any.
    """
    found = judged(task, points, "train")
    impossible, lost = np.isnan(found.error), np.isinf(found.error)
    error = np.where(impossible | lost, 1.0, np.maximum(found.error, TINIEST))
    activity = np.where(impossible | lost, 1.0, np.maximum(found.activity, CALMEST))
    logs = np.log(error) + task.effort * np.log(activity)
    total: Numbers = np.where(lost, LOST, logs).mean(axis=1) + np.where(lost.any(axis=1), LOST, 0.0)
    return np.where(impossible.any(axis=1), np.inf, total)


def judged(task: Task, points: Points, split: str) -> Judged:
    """How points do under the conditions of a split, these in the order of their groups.

    The error of a point that allows no controller is nan.

    Raises:
        HydroservoError: a condition allows no machine, or the metric is nan in a run that was not lost.
    """
    count = next(iter(points.values())).size
    parts = []
    for group in task.groups:
        if split not in group.drawn:
            continue
        possible = np.arange(count)
        while possible.size:
            try:
                part = simulated(task, group, {path: one[possible] for path, one in points.items()}, split)
                break
            except ParameterError as refusal:
                allowed = np.array([is_possible(group.loop, points, int(k)) for k in possible])
                if allowed.all():
                    raise HydroservoError(f"{task.law} in {task.cell}: {refusal}") from None
                possible = possible[allowed]
        size = group.drawn[split].numbers.size
        error, activity = (np.full((count, size), np.nan) for _ in range(2))
        if possible.size:
            error[possible], activity[possible] = part
        parts.append((error, activity))
    return Judged(*(np.concatenate(one, axis=1) for one in zip(*parts, strict=True)))


def simulated(task: Task, group: Group, points: Points, split: str) -> Judged:
    """The same of one group, all of whose points allow a controller.

    Raises:
        ParameterError: one does not, or the metric is nan in a run that was not lost.
    """
    drawn = group.drawn[split]
    count, size = next(iter(points.values())).size, drawn.numbers.size
    columns = {path: np.repeat(values, size) for path, values in points.items()}
    columns |= {path: np.tile(values, count) for path, values in drawn.columns.items()}
    monitors = needed(group.loop, {task.metric, ACTIVITY})
    runs = quietly(simulate_batch)(group.loop, columns, metrics=monitors, threads=1, strict=True)
    error = np.where(runs["diverged"].values, np.inf, runs[task.metric].values)
    if np.isnan(error).any():
        raise ParameterError("metric", task.metric, "is nan in runs that were not lost; use another")
    simulation = group.loop.simulation
    share = 100.0 / (command_range(group.loop) * simulation.duration)
    activity = runs[ACTIVITY].values * share
    return Judged(error.reshape(count, size), activity.reshape(count, size))


def command_range(loop: Loop) -> float:
    """From the least command to the largest [V]: of the law's outermost limiter, or what opens the valve.

    Raises:
        ParameterError: neither says so.
    """
    limits = {path: value for path, value in leaves(loop.controller) if path.endswith("saturation.limit")}
    if limits:
        return 2.0 * float(limits[min(limits, key=lambda path: path.count("."))])
    valve: Any = loop.valve
    if not hasattr(valve, "max_opening") or not hasattr(valve, "gain"):
        raise ParameterError("controller", type(loop.controller).__name__, "must limit its command")
    return 2.0 * float(valve.max_opening / valve.gain)


def table_of(
    task: Task, budgets: Sequence[int], points: Sequence[Mapping[str, float]], edges: Sequence[Sequence[str]]
) -> "pa.Table":
    """The rows of a search: split by split, budget by budget, condition by condition.

    Args:
        task: the search.
        budgets: the numbers of candidates after which its best was judged.
        points: that best after each of them, by path, in SI units.
        edges: the paths that are at an end of their range there.
    """
    import pyarrow as pa

    values = {path: np.array([one[path] for one in points]) for path in points[0]}
    schema = pa.schema([(name, getattr(pa, kind)()) for name, kind in COLUMNS.items()])
    tables = []
    for split in splits_of(task.groups):
        found, (numbers, scales) = judged(task, values, split), of_conditions(task.groups, split)
        order = np.argsort(numbers)
        for i, budget in enumerate(budgets):
            error = np.where(np.isnan(found.error[i]), np.inf, found.error[i])
            of_runs = {
                "condition": numbers,
                "scale": scales,
                "error": error,
                "activity": found.activity[i],
                "lost": np.isinf(error),
            }
            of_all = {
                "law": task.law,
                "cell": task.cell,
                "optimiser": task.optimiser,
                "search_seed": task.seed,
                "effort": task.effort,
                "budget": budget,
                "split": split,
                "parameters": json.dumps(dict(points[i])),
                "edges": json.dumps(list(edges[i])),
            }
            rows = {name: column[order] for name, column in of_runs.items()}
            rows |= {name: [value] * order.size for name, value in of_all.items()}
            tables.append(pa.table(rows, schema=schema))
    return pa.concat_tables(tables).combine_chunks()


def splits_of(groups: Sequence[Group]) -> list[str]:
    return list(dict.fromkeys(split for group in groups for split in group.drawn))


def of_conditions(groups: Sequence[Group], split: str) -> tuple[NDArray[np.int64], Numbers]:
    """The numbers of a split's conditions, and their scales, in the order of the groups."""
    own = [group.drawn[split] for group in groups if split in group.drawn]
    return np.concatenate([one.numbers for one in own]), np.concatenate([one.scales for one in own])
