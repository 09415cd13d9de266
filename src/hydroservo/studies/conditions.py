"""The conditions of a cell, drawn alike for every law, and how points of a law's gains do under them."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.core.block import field_at, leaves
from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError
from hydroservo.core.validation import allowed, within
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.columns import SEED
from hydroservo.runs.objective import ACTIVITY, is_possible, needed_monitors
from hydroservo.scenario.load import Assembly
from hydroservo.scenario.parameter_draws import (
    Variation,
    draw_values,
    loop_parameters,
    uniform_numbers,
    variation_at,
)
from hydroservo.scenario.tables import TableEntry
from hydroservo.studies.spec import AxisLevel, ConditionKind, ConditionPlan, StudySpec

SPLITS = ("train", "validation", "test", "stress")
MACHINE = ("plant.", "valve.", "supply.", "drive.")  # whose deviations are stressed: loads are none
LAW = "controller."
NOISE = 1_000_000  # seeds of noise between one split and the next

Numbers = NDArray[np.float64]
Points = Mapping[str, Numbers]  # arrays of shape (points,) by path
ActivityWindow = tuple[float, float]  # logarithms of the least and the largest activity that count

LOST = 60.0  # what a lost run adds to the mean logarithm: more than any metric and activity can differ by
TINIEST = 1e-300  # of errors: below it they are alike
CALMEST = 1e-6  # [% of the range a second] a command that varies less is not worth more


class DrawnConditions(NamedTuple):
    """The conditions of one kind in one split."""

    numbers: NDArray[np.int64]  # of the conditions in their split
    scales: Numbers  # on the deviations of the machine; nan but in the split stress
    columns: Mapping[str, NDArray[Any]]  # by path in the loop, in SI units: what simulate_batch takes
    changes: Mapping[str, NDArray[Any]]  # by path in a scenario, in SI units: what makes one of them alone


def draw_conditions(
    study: StudySpec, levels: Sequence[AxisLevel], assemblies: Mapping[str, Assembly]
) -> dict[str, dict[str, DrawnConditions]]:
    """The conditions of a cell by split and by kind.

    Each number is a function of the study's seed, its split, its path and the number of the condition alone,
    so that all laws meet the same ones, and no other law, cell or count changes them.

    Source: Philox4x64-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    asked = study.conditions
    found: dict[str, dict[str, DrawnConditions]] = {}
    for split in SPLITS:
        if split == "stress" and not asked.stress:
            continue
        found[split] = {
            kind.name: draw_kind(study, split, i, varied_entries(study, levels, kind), assemblies[kind.name])
            for i, kind in enumerate(asked.kinds)
        }
    check_apart(study, found)
    return {
        split: {name: one for name, one in own.items() if one.numbers.size} for split, own in found.items()
    }


def varied_entries(
    study: StudySpec, levels: Sequence[AxisLevel], kind: ConditionKind
) -> dict[str, TableEntry]:
    """What is drawn for the conditions of a kind, by path."""
    found = dict(study.conditions.vary)
    for level in levels:
        found |= level.vary
    found |= kind.vary
    for path, entry in found.items():
        if path.startswith(LAW):
            problem = "belongs to a law; conditions concern the machine, its load, demand and sensors"
            raise ScenarioError(entry.origin.name, entry.key, problem)
    return found


class ConditionNumbers(NamedTuple):
    """Which conditions of a split are of one kind."""

    numbers: NDArray[np.int64]  # in the split
    source: str  # the split whose draws they have: stress takes those of test
    drawn: NDArray[np.int64]  # their numbers there
    scales: Numbers  # on the deviations of the machine; nan but in the split stress


def condition_numbers(asked: ConditionPlan, split: str, which: int) -> ConditionNumbers:
    """Every so many conditions of a split, those of a kind."""
    if split != "stress":
        own = np.arange(which, asked.counts[split], len(asked.kinds))
        return ConditionNumbers(own, split, own, np.full(own.size, np.nan))
    own, scales = np.arange(which, asked.stressed, len(asked.kinds)), np.arange(len(asked.stress))
    numbers = (scales[:, np.newaxis] * asked.stressed + own).ravel()
    return ConditionNumbers(numbers, "test", np.tile(own, scales.size), np.repeat(asked.stress, own.size))


def draw_kind(
    study: StudySpec, split: str, which: int, ranges: Mapping[str, TableEntry], assembly: Assembly
) -> DrawnConditions:
    at = condition_numbers(study.conditions, split, which)
    made = [variation_at(assembly, path, entry) for path, entry in ranges.items()]
    values = {}
    for one in made:
        stream = uniform_numbers(
            study.conditions.seed, f"{at.source} {one.path}", study.conditions.counts[at.source]
        )
        values[one.path], deviation = draw_values(one, stream[at.drawn])
        if split == "stress" and one.path.startswith(MACHINE) and deviation is not None:
            values[one.path] = stressed_values(study, one, assembly, at.scales * deviation)
    seeds = assembly.loop.simulation.seed + SPLITS.index(at.source) * NOISE + at.drawn
    columns = dict(loop_parameters(assembly, made, values)) | {SEED: seeds}
    return DrawnConditions(at.numbers, at.scales, columns, values | {SEED: seeds})


def stressed_values(study: StudySpec, one: Variation, assembly: Assembly, deviation: Numbers) -> Numbers:
    found: Numbers = np.asarray(one.nominal) * (1.0 + deviation)
    field = (
        assembly.arguments[one.path].field
        if one.path in assembly.arguments
        else field_at(assembly.loop, one.path)
    )
    for value in (found.min(), found.max()) if found.size else ():
        if not within(float(value), field):
            problem = f"leads to {one.path} = {value:g}; it must be {allowed(field)}"
            raise ScenarioError(study.origin.name, "conditions.stress", problem)
    return found


def check_apart(study: StudySpec, found: Mapping[str, Mapping[str, DrawnConditions]]) -> None:
    """Refuse a condition that a law is judged by and was searched under."""
    seen: dict[tuple[object, ...], str] = {}
    for split in SPLITS[:3]:
        for kind, one in found[split].items():
            rows = [column.tolist() for path, column in one.changes.items() if path != SEED]
            for i, number in enumerate(one.numbers.tolist()):
                row = (kind, *(column[i] for column in rows))
                if seen.setdefault(row, split) != split:
                    problem = (
                        f"condition {number} is also one of {seen[row]}; let more vary in [conditions.vary]"
                    )
                    raise ScenarioError(study.origin.name, f"conditions.{split}", problem)


class ConditionGroup(NamedTuple):
    """The loop for one kind of condition, and the conditions of that kind by split."""

    loop: Loop  # as it is judged
    coarse: Loop  # the same with the longer integration steps of a search
    drawn: Mapping[str, DrawnConditions]  # the conditions, by split


class SearchTask(NamedTuple):
    """One search of a law's gains in one cell."""

    law: str  # its name
    cell: str  # its name
    seed: int  # of the search
    metric: str  # what is to be small beside the command's activity
    candidates: int  # the most that are tried
    widen: int  # how often a range may be widened at whose end a point of the front lies
    calmest: float  # the least activity that counts, over that of the law that others are held against
    window: ActivityWindow | None  # the activities that count; None for that law, which finds its own
    ranges: Mapping[str, tuple[float, float]]  # between what numbers are searched, in SI units, by path
    groups: Sequence[ConditionGroup]  # the loops and their conditions


class Evaluation(NamedTuple):
    """How points do under conditions: arrays of shape (points, conditions)."""

    error: Numbers  # inf where a run was lost
    activity: Numbers  # total variation of the command in percent of its range a second
    swing: Numbers  # amplitude of the command in a sustained oscillation [V]; nan where it is not known


def mean_logs(found: Evaluation, *penalties: float) -> Numbers:
    """The mean logarithms of error and of activity over the runs that were not lost, shape (points, 2).

    A point that allows no controller is infinitely bad.
    """
    impossible, lost = np.isnan(found.error).any(axis=1), np.isinf(found.error)
    kept = np.maximum((~lost).sum(axis=1), 1)
    columns = []
    for values, smallest, penalty in zip(found[:2], (TINIEST, CALMEST), penalties, strict=True):
        logs = np.log(np.where(lost, 1.0, np.maximum(values, smallest)))
        columns.append(np.where(impossible, np.inf, logs.sum(axis=1) / kept + penalty * lost.sum(axis=1)))
    return np.stack(columns, axis=1)


def evaluate(task: SearchTask, points: Points, split: str) -> Evaluation:
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
                part = simulate_points(
                    task, group, {path: one[possible] for path, one in points.items()}, split
                )
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


def simulate_points(task: SearchTask, group: ConditionGroup, points: Points, split: str) -> Evaluation:
    """The same of one group, all of whose points allow a controller."""
    drawn, loop = group.drawn[split], group.coarse if split == "train" else group.loop
    count, size = next(iter(points.values())).size, drawn.numbers.size
    columns = {path: np.repeat(values, size) for path, values in points.items()}
    columns |= {path: np.tile(values, count) for path, values in drawn.columns.items()}
    monitors = needed_monitors(loop, {task.metric, ACTIVITY})
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
