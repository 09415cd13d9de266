"""What a search makes small: the metric of loops as a number, for many candidates at once."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.metrics import declared_metrics, judged_by, monitors_of
from hydroservo.core.block import Block, field_at, value_at
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.field import Field
from hydroservo.core.formatting import is_number
from hydroservo.core.validation import checked, whole_number, within
from hydroservo.runs.arguments import check_one_signal
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.columns import SEED, checked_columns, designed_columns, start_columns
from hydroservo.runs.step_sizes import with_substeps

if TYPE_CHECKING:
    import xarray as xr

ACTIVITY = "control_total_variation"
LARGEST = 1e300  # of weights and effort
WHOLE = {"seeds": (1, 10_000), "candidates": (0, 10_000_000), "seed": (0, 2**63 - 1)}  # ranges by name


class Aim(NamedTuple):
    """What is to be small: the weighted geometric mean of a metric over loops, each its mean over seeds.

    With an ``effort`` e > 0 the metric of each loop is multiplied by its control_total_variation^e, so that a
    calmer command is worth something: with e = 0.1, one a tenth as lively is worth a fifth of the metric.

    Attributes:
        loops: the loops, all with the same controller.
        weights: of each loop's metric in the geometric mean; alike if none are given.
        metric: name of a metric of which less is better, such as those of
            :class:`~hydroservo.control.monitors.TrackingError`; another name is refused with those that there
            are.
        seeds: how many seeds each candidate is simulated with, from the loop's own on.
        effort: exponent e of the command's total variation, at least 0.
        metrics: the monitors that the metric comes from, in place of the loops' own, as of
            :func:`~hydroservo.simulate`; the loops' own if None.
    """

    loops: Sequence[Loop]
    weights: Sequence[float] = ()
    metric: str = "rms_error"
    seeds: int = 1
    effort: float = 0.0
    metrics: Mapping[str, Block] | Sequence[Block] | None = None


def checked_aim(aim: Aim) -> Aim:
    """An aim with a weight for each of its loops."""
    check_one_signal("loops", [loop.controls.declared().meaning for loop in aim.loops])
    metric_field(aim.loops, aim.metric)
    count = len(aim.loops)
    none = isinstance(aim.weights, list | tuple) and not aim.weights
    weights = (1.0,) * count if none else checked_weights(aim.weights, count, "loop")
    seeds, effort = checked_whole("seeds", aim.seeds), checked_effort(aim.effort)
    if effort and ACTIVITY not in judged_by(aim.loops):
        raise ParameterError("effort", effort, f"must be 0 for a loop without the metric {ACTIVITY}")
    return aim._replace(weights=weights, seeds=seeds, effort=effort)


def metric_field(loops: Sequence[Loop], metric: object) -> Field:
    """The declaration of a metric that loops can be tuned by."""
    if not isinstance(metric, str):
        raise ParameterError("metric", metric, "must be the name of a metric")
    known = judged_by(loops)
    if metric not in known:
        raise ParameterError("metric", metric, one_of(metric, known))
    return known[metric]


def checked_weights(value: object, count: int, each: str) -> tuple[float, ...]:
    """Weights in a geometric mean."""
    found = finite_numbers(value)
    if len(found) != count or min(found) <= 0.0:
        raise ParameterError("weights", value, f"must be a number above 0 for each {each}; there are {count}")
    return found


def checked_effort(value: object) -> float:
    """An exponent of the command's total variation."""
    found = finite_numbers([value])
    if not found or found[0] < 0.0:
        raise ParameterError("effort", value, "must be a finite number, at least 0")
    return found[0]


def checked_whole(name: str, value: object) -> int:
    """The number of seeds or candidates, or the seed of a search."""
    return whole_number(name, value, *WHOLE[name])


def finite_numbers(value: object) -> tuple[float, ...]:
    """The numbers in a list; none where it holds anything but finite numbers, or is no list."""
    found = tuple(value) if isinstance(value, (list, tuple, np.ndarray)) else ()
    return tuple(map(float, found)) if all(map(is_finite, found)) else ()


def is_finite(value: Any) -> bool:
    return is_number(value) and bool(abs(value) < LARGEST)


def check_ranges(loops: Sequence[Loop], ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse what is no range of a number that all loops have."""
    if not ranges:
        raise ParameterError("ranges", "{}", "must name at least one parameter")
    for path, ends in ranges.items():
        pair = finite_numbers(ends)
        for loop in loops:
            try:
                present, field = value_at(loop, path), field_at(loop, path)
            except ParameterError as error:
                raise ParameterError("ranges", path, error.allowed) from None
            if not isinstance(present, float):
                raise ParameterError("ranges", path, "must be the path of a float")
            if len(pair) != 2 or not (pair[0] < pair[1] and all(within(end, field) for end in pair)):
                raise ParameterError(path, ends, "must be a range of allowed values, low before high")


def geometric_mean(weights: Sequence[float], metrics: Sequence[float]) -> float:
    """The weighted geometric mean of the loops' metrics; inf where a run was lost."""
    pairs = zip(weights, metrics, strict=True)
    return float(math.prod(metric ** (weight / math.fsum(weights)) for weight, metric in pairs))


Numbers = NDArray[np.float64]
Columns = Mapping[str, Numbers]

LOST = 1e30  # counts as the metric of a run that diverged: beyond that of any other, in whatever unit
SAFE = 1e20  # a mean over seeds is below this unless it counts a lost run
OUTSIDE = 150.0  # cost beyond bounds: more than the logarithm of LOST, with all that a violation adds
PENALTY = 400.0  # on the cost of a lost run: more than metrics between 1/LOST and LOST can differ by
CALMEST = 1e-6  # [V] a command that varies less is not worth more


class CandidateOutcome(NamedTuple):
    """The metric of candidates and the total variation of their command, means over the seeds."""

    error: Numbers  # the metric; ``LOST`` or more where a run was lost or the candidate allows no controller
    activity: Numbers  # of the command [V]; nan where the loop does not have that metric


def candidate_outcome(aim: Aim, i: int, candidates: Columns, threads: int | None) -> CandidateOutcome:
    wanted = {aim.metric} | ({ACTIVITY} & judged_by([aim.loops[i]]).keys())
    try:
        return outcome_of_runs(
            aim, i, candidate_runs(aim, i, candidates, threads, needed_monitors(aim.loops[i], wanted))
        )
    except ParameterError:
        count = next(iter(candidates.values())).size
        possible = np.array([is_possible(aim.loops[i], candidates, k) for k in range(count)])
        if possible.all():
            raise
        every = CandidateOutcome(np.full(count, LOST), np.full(count, math.nan))
        if possible.any():
            kept = {path: values[possible] for path, values in candidates.items()}
            every.error[possible], every.activity[possible] = candidate_outcome(aim, i, kept, threads)
        return every


def outcome_of_runs(aim: Aim, i: int, runs: "xr.Dataset") -> CandidateOutcome:
    error = candidate_means(aim, i, runs)
    if ACTIVITY not in runs:
        return CandidateOutcome(error, np.full(error.size, math.nan))
    return CandidateOutcome(error, runs[ACTIVITY].values.reshape(-1, aim.seeds).mean(axis=1))


def outcomes_at(
    aim: Aim, points: Sequence[Mapping[str, float]], threads: int | None
) -> tuple[list["xr.Dataset"], list[CandidateOutcome]]:
    """The runs of each loop with parameters of its own, and what comes of them."""
    columns = [{path: np.array([value]) for path, value in point.items()} for point in points]
    tables = [candidate_runs(aim, i, one, threads) for i, one in enumerate(columns)]
    return tables, [outcome_of_runs(aim, i, table) for i, table in enumerate(tables)]


def with_fixed_steps(aim: Aim, tables: Sequence["xr.Dataset"]) -> Aim:
    """An aim whose loops take as many substeps as their own values need, where these are to be found."""
    pairs = zip(aim.loops, tables, strict=True)
    loops = [
        with_substeps(loop, int(table.attrs["substeps"])) if "substeps" in table.attrs else loop
        for loop, table in pairs
    ]
    return aim._replace(loops=loops)


def needed_monitors(loop: Loop, wanted: set[str]) -> dict[str, Block]:
    """The monitors that some metrics come from: others would only take time."""
    every = monitors_of(loop)
    own = {name: one for name, one in every.items() if wanted & set(declared_metrics({name: one}))}
    return own if wanted <= set(declared_metrics(own)) else every


def is_possible(loop: Loop, candidates: Columns, k: int) -> bool:
    """Whether candidate k allows a machine and a controller."""
    own = {path: values[k : k + 1] for path, values in candidates.items()}
    try:
        checked_columns(loop, own)
        start_columns(checked(loop), own)
        designed_columns(loop, own)
    except ParameterError:
        return False
    return True


def candidate_runs(
    aim: Aim, i: int, candidates: Columns, threads: int | None, metrics: Mapping[str, Block] | None = None
) -> "xr.Dataset":
    """The runs of loop i: of the first candidate with each seed, of the second, and so on.

    Their metrics are those of some monitors, or all that the loop has.
    """
    loop = aim.loops[i]
    count = next(iter(candidates.values())).size
    columns: dict[str, Any] = {path: np.repeat(values, aim.seeds) for path, values in candidates.items()}
    columns[SEED] = np.tile(loop.simulation.seed + np.arange(aim.seeds), count)
    return quietly(simulate_batch)(loop, columns, metrics=metrics, threads=threads)


def candidate_means(aim: Aim, i: int, runs: "xr.Dataset") -> Numbers:
    """The metric of each candidate, mean over the seeds."""
    values = runs[aim.metric].values
    lost = runs["diverged"].values | np.isinf(values)
    if np.isnan(values[~lost]).any():
        which = f"loop {i + 1} of {len(aim.loops)}"
        raise ParameterError("metric", aim.metric, f"must be one that every loop has; it is nan in {which}")
    found: Numbers = np.where(lost, LOST, values).reshape(-1, aim.seeds).mean(axis=1)
    return found


def search_costs(aim: Aim, outcomes: Sequence[CandidateOutcome]) -> Numbers:
    """What is made small: the logarithm of the loops' geometric mean, and a penalty where a run was lost."""
    metrics = [one.error * effort_factor(aim, one.activity) for one in outcomes]
    bounded = [np.clip(metric, 1.0 / LOST, LOST) for metric in metrics]
    total = sum(weight * np.log(one) for weight, one in zip(aim.weights, bounded, strict=True))
    lost = np.max(metrics, axis=0) >= SAFE
    return np.asarray(total / math.fsum(aim.weights) + np.where(lost, PENALTY, 0.0))


def effort_factor(aim: Aim, activity: Numbers) -> Numbers:
    """The factor that the command's total variation is on a candidate's metric."""
    known = np.where(np.isfinite(activity), activity, 1.0)
    factor: Numbers = np.maximum(known, CALMEST) ** aim.effort
    return factor


def mean_of_cost(cost: float) -> float:
    """The geometric mean that a cost stands for; inf where a run was lost, or bounds are not kept."""
    return math.exp(cost) if cost < OUTSIDE else math.inf
