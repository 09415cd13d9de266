"""How points of a law's gains do under conditions, and what that comes to."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import leaves
from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.loop import Loop
from hydroservo.monitors import Oscillation
from hydroservo.runs.aims import ACTIVITY
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.objective import is_possible, needed
from hydroservo.studies.conditions import Drawn

Numbers = NDArray[np.float64]
Points = Mapping[str, Numbers]  # arrays of shape (points,) by path
Window = tuple[float, float]  # logarithms of the least and the largest activity that count

LOST = 60.0  # what a lost run adds to the mean logarithm: more than any metric and activity can differ by
TINIEST = 1e-300  # of errors: below it they are alike
CALMEST = 1e-6  # [% of the range a second] a command that varies less is not worth more


class Group(NamedTuple):
    """The loop for one kind of condition, and the conditions of that kind by split.

    Attributes:
        loop: as it is judged.
        coarse: the same with the longer integration steps of a search.
        drawn: the conditions, by split.
    """

    loop: Loop
    coarse: Loop
    drawn: Mapping[str, Drawn]


class Task(NamedTuple):
    """One search of a law's gains in one cell.

    Attributes:
        law: its name.
        cell: its name.
        seed: of the search.
        metric: what is to be small beside the command's activity.
        candidates: the most that are tried.
        widen: how often a range may be widened at whose end a point of the front lies.
        calmest: the least activity that counts, over that of the law that others are held against.
        window: the activities that count; None for that law, which finds its own.
        ranges: between what numbers are searched, in SI units, by path.
        groups: the loops and their conditions.
    """

    law: str
    cell: str
    seed: int
    metric: str
    candidates: int
    widen: int
    calmest: float
    window: Window | None
    ranges: Mapping[str, tuple[float, float]]
    groups: Sequence[Group]


class Evaluation(NamedTuple):
    """How points do under conditions: arrays of shape (points, conditions)."""

    error: Numbers  # inf where a run was lost
    activity: Numbers  # total variation of the command in percent of its range a second
    swing: Numbers  # amplitude of the command in a sustained oscillation [V]; nan where it is not known


def mean_logs(found: Evaluation, *penalties: float) -> Numbers:
    """The mean logarithms of error and of activity over the runs that were not lost, shape (points, 2).

    A point that allows no controller is infinitely bad.

    Args:
        found: how the points do.
        penalties: what each lost run adds to the error and to the activity.
    """
    impossible, lost = np.isnan(found.error).any(axis=1), np.isinf(found.error)
    kept = np.maximum((~lost).sum(axis=1), 1)
    columns = []
    for values, smallest, penalty in zip(found[:2], (TINIEST, CALMEST), penalties, strict=True):
        logs = np.log(np.where(lost, 1.0, np.maximum(values, smallest)))
        columns.append(np.where(impossible, np.inf, logs.sum(axis=1) / kept + penalty * lost.sum(axis=1)))
    return np.stack(columns, axis=1)


def evaluate(task: Task, points: Points, split: str) -> Evaluation:
    """How points do under the conditions of a split, these in the order of their groups.

    The error of a point that allows no controller is nan.
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
        whole = np.full((len(Evaluation._fields), count, group.drawn[split].numbers.size), np.nan)
        if possible.size:
            whole[:, possible] = part
        parts.append(whole)
    return Evaluation(*(np.concatenate(one, axis=1) for one in zip(*parts, strict=True)))


def simulated(task: Task, group: Group, points: Points, split: str) -> Evaluation:
    """The same of one group, all of whose points allow a controller."""
    drawn, loop = group.drawn[split], group.coarse if split == "train" else group.loop
    count, size = next(iter(points.values())).size, drawn.numbers.size
    columns = {path: np.repeat(values, size) for path, values in points.items()}
    columns |= {path: np.tile(values, count) for path, values in drawn.columns.items()}
    monitors = needed(loop, {task.metric, ACTIVITY})
    if split == "test":
        monitors |= {"oscillation": Oscillation()}
    runs = quietly(simulate_batch)(loop, columns, metrics=monitors, threads=1, strict=True)
    error = np.where(runs["diverged"].values, np.inf, runs[task.metric].values)
    if np.isnan(error).any():
        raise ParameterError("metric", task.metric, "is nan in runs that were not lost; use another")
    share = 100.0 / (command_range(loop) * loop.simulation.duration)
    activity = runs[ACTIVITY].values * share
    swing = runs["oscillation_command"].values if split == "test" else np.full(error.shape, np.nan)
    return Evaluation(*(one.reshape(count, size) for one in (error, activity, swing)))


def command_range(loop: Loop) -> float:
    """From the least command to the largest [V]: of the law's outermost limiter, or what opens the valve."""
    limits = {path: value for path, value in leaves(loop.controller) if path.endswith("saturation.limit")}
    if limits:
        return 2.0 * float(limits[min(limits, key=lambda path: path.count("."))])
    valve: Any = loop.valve
    if not hasattr(valve, "max_opening") or not hasattr(valve, "gain"):
        raise ParameterError("controller", type(loop.controller).__name__, "must limit its command")
    return 2.0 * float(valve.max_opening / valve.gain)
