"""The metric of loops as a number to make small, for many candidates at once."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, judged_by, monitors_of
from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError
from hydroservo.core.validation import checked
from hydroservo.runs.aims import ACTIVITY, Aim
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.columns import SEED, checked_columns, designs, starts
from hydroservo.runs.step_sizes import with_substeps

if TYPE_CHECKING:
    import xarray as xr

Numbers = NDArray[np.float64]
Columns = Mapping[str, Numbers]

LOST = 1e30  # counts as the metric of a run that diverged: beyond that of any other, in whatever unit
SAFE = 1e20  # a mean over seeds is below this unless it counts a lost run
OUTSIDE = 150.0  # cost beyond bounds: more than the logarithm of LOST, with all that a violation adds
PENALTY = 400.0  # on the cost of a lost run: more than metrics between 1/LOST and LOST can differ by
CALMEST = 1e-6  # [V] a command that varies less is not worth more


class Outcome(NamedTuple):
    """The metric of candidates and the total variation of their command, means over the seeds.

    Attributes:
        error: the metric; ``LOST`` or more where a run was lost or the candidate allows no controller.
        activity: of the command [V]; nan where the loop does not have that metric.
    """

    error: Numbers
    activity: Numbers


def outcome(aim: Aim, i: int, candidates: Columns, threads: int | None) -> Outcome:
    """The outcome of loop i with each candidate."""
    wanted = {aim.metric} | ({ACTIVITY} & judged_by([aim.loops[i]]).keys())
    try:
        return outcome_of(aim, i, runs_of(aim, i, candidates, threads, needed(aim.loops[i], wanted)))
    except ParameterError:
        count = next(iter(candidates.values())).size
        possible = np.array([is_possible(aim.loops[i], candidates, k) for k in range(count)])
        if possible.all():
            raise
        every = Outcome(np.full(count, LOST), np.full(count, math.nan))
        if possible.any():
            kept = {path: values[possible] for path, values in candidates.items()}
            every.error[possible], every.activity[possible] = outcome(aim, i, kept, threads)
        return every


def outcome_of(aim: Aim, i: int, runs: "xr.Dataset") -> Outcome:
    """The outcome of each candidate in the runs of loop i."""
    error = means(aim, i, runs)
    if ACTIVITY not in runs:
        return Outcome(error, np.full(error.size, math.nan))
    return Outcome(error, runs[ACTIVITY].values.reshape(-1, aim.seeds).mean(axis=1))


def at_points(
    aim: Aim, points: Sequence[Mapping[str, float]], threads: int | None
) -> tuple[list["xr.Dataset"], list[Outcome]]:
    """The runs of each loop with parameters of its own, and what comes of them."""
    columns = [{path: np.array([value]) for path, value in point.items()} for point in points]
    tables = [runs_of(aim, i, one, threads) for i, one in enumerate(columns)]
    return tables, [outcome_of(aim, i, table) for i, table in enumerate(tables)]


def with_fixed_steps(aim: Aim, tables: Sequence["xr.Dataset"]) -> Aim:
    """An aim whose loops take as many substeps as their own values need, where these are to be found."""
    pairs = zip(aim.loops, tables, strict=True)
    loops = [
        with_substeps(loop, int(table.attrs["substeps"])) if "substeps" in table.attrs else loop
        for loop, table in pairs
    ]
    return aim._replace(loops=loops)


def needed(loop: Loop, wanted: set[str]) -> dict[str, Block]:
    """The monitors that some metrics come from: others would only take time."""
    every = monitors_of(loop)
    own = {name: one for name, one in every.items() if wanted & set(declared_metrics({name: one}))}
    return own if wanted <= set(declared_metrics(own)) else every


def is_possible(loop: Loop, candidates: Columns, k: int) -> bool:
    """Whether candidate k allows a machine and a controller."""
    own = {path: values[k : k + 1] for path, values in candidates.items()}
    try:
        checked_columns(loop, own)
        starts(checked(loop), own)
        designs(loop, own)
    except ParameterError:
        return False
    return True


def runs_of(
    aim: Aim,
    i: int,
    candidates: Columns,
    threads: int | None,
    metrics: Mapping[str, Block] | None = None,
) -> "xr.Dataset":
    """The runs of loop i: of the first candidate with each seed, of the second, and so on.

    Their metrics are those of some monitors, or all that the loop has.
    """
    loop = aim.loops[i]
    count = next(iter(candidates.values())).size
    columns: dict[str, Any] = {path: np.repeat(values, aim.seeds) for path, values in candidates.items()}
    columns[SEED] = np.tile(loop.simulation.seed + np.arange(aim.seeds), count)
    return quietly(simulate_batch)(loop, columns, metrics=metrics, threads=threads)


def means(aim: Aim, i: int, runs: "xr.Dataset") -> Numbers:
    """The metric of each candidate, mean over the seeds."""
    values = runs[aim.metric].values
    lost = runs["diverged"].values | np.isinf(values)
    if np.isnan(values[~lost]).any():
        which = f"loop {i + 1} of {len(aim.loops)}"
        raise ParameterError("metric", aim.metric, f"must be one that every loop has; it is nan in {which}")
    found: Numbers = np.where(lost, LOST, values).reshape(-1, aim.seeds).mean(axis=1)
    return found


def costs(aim: Aim, outcomes: Sequence[Outcome]) -> Numbers:
    """What is made small: the logarithm of the loops' geometric mean, and a penalty where a run was lost."""
    metrics = [one.error * effort(aim, one.activity) for one in outcomes]
    bounded = [np.clip(metric, 1.0 / LOST, LOST) for metric in metrics]
    total = sum(weight * np.log(one) for weight, one in zip(aim.weights, bounded, strict=True))
    lost = np.max(metrics, axis=0) >= SAFE
    return np.asarray(total / math.fsum(aim.weights) + np.where(lost, PENALTY, 0.0))


def effort(aim: Aim, activity: Numbers) -> Numbers:
    """The factor that the command's total variation is on a candidate's metric."""
    known = np.where(np.isfinite(activity), activity, 1.0)
    factor: Numbers = np.maximum(known, CALMEST) ** aim.effort
    return factor


def mean_of(cost: float) -> float:
    """The geometric mean that a cost stands for; inf where a run was lost, or bounds are not kept."""
    return math.exp(cost) if cost < OUTSIDE else math.inf
