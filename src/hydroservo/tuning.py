"""The best gains of a loop, by a search that treats every law alike."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.batch import simulate_batch
from hydroservo.block import Block, field_at, value_at
from hydroservo.cautions import quietly, warnings_of
from hydroservo.checks import checked, within
from hydroservo.errors import HydroservoError, HydroservoWarning, ParameterError
from hydroservo.loop import Loop
from hydroservo.metrics import declared_metrics, judged_by, monitors_of
from hydroservo.nearest import one_of
from hydroservo.varied import SEED, checked_columns, designs, starts
from hydroservo.wiring import wired

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Aim", "Progress", "Tuned", "tune"]

Numbers = NDArray[np.float64]
Columns = Mapping[str, Numbers]
Progress = Callable[[float, float], None]  # called with the fraction done and the best geometric mean so far

LOST = 1e30  # counts as the metric of a run that diverged: beyond that of any other, in whatever unit
ACTIVITY = "control_total_variation"
SAFE = 1e20  # a mean over seeds is below this unless it counts a lost run
CANDIDATES = 64  # of a generation: whole groups of lanes
PENALTY = 400.0  # on the cost of a lost run: more than metrics between 1/LOST and LOST can differ by
CALMEST = 1e-6  # [V] a command that varies less is not worth more
DIGITS = 5  # of what is found; a rig's gains have no more


class Aim(NamedTuple):
    """What is to be small: the weighted geometric mean of a metric over loops, each its mean over seeds.

    With an ``effort`` e > 0 the metric of each loop is multiplied by its control_total_variation^e, so that a
    calmer command is worth something: with e = 0.1, one a tenth as lively is worth a fifth of the metric.

    Attributes:
        loops: the loops, all with the same controller.
        weights: of each loop's metric in the geometric mean; alike if none are given.
        metric: name of a metric that is the better the smaller it is.
        seeds: how many seeds each candidate is simulated with, from the loop's own on.
        effort: exponent e of the command's total variation, at least 0.
    """

    loops: Sequence[Loop]
    weights: Sequence[float] = ()
    metric: str = "rms_error"
    seeds: int = 1
    effort: float = 0.0


class Tuned(NamedTuple):
    """What a search found.

    Attributes:
        parameters: the best values by path, in SI units, rounded to five digits.
        before: the metric of each loop with its own values, mean over the seeds; inf where a run diverged.
        after: the same with the best values.
        cost: the weighted geometric mean of the metrics after, without effort.
        runs: how many closed loops the search simulated.
        edges: the paths whose best value lies within a hundredth of an end of its range.
        tables: the runs of each loop with the best values, one for each seed, as simulate_batch returns them.
    """

    parameters: Mapping[str, float]
    before: Sequence[float]
    after: Sequence[float]
    cost: float
    runs: int
    edges: Sequence[str]
    tables: Sequence[Any]  # datasets of xarray, which is heavy to import

    def __repr__(self) -> str:
        lines = [f"{path} = {value:g}" for path, value in self.parameters.items()]
        metrics = enumerate(zip(self.before, self.after, strict=True), 1)
        lines += [f"loop {i}: {before:.3g} -> {after:.3g}" for i, (before, after) in metrics]
        edges = f"; at an end of its range: {', '.join(self.edges)}" if self.edges else ""
        return "\n".join([*lines, f"{self.runs} closed loops were simulated{edges}"])


def tune(
    aim: Aim,
    ranges: Mapping[str, tuple[float, float]],
    *,
    candidates: int = 4096,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Tuned:
    """Search the parameters of a loop that make a metric smallest.

    Differential evolution (best/1/bin, 64 candidates a generation) in the logarithm of each parameter whose
    range does not hold 0, in the parameter itself otherwise. The same seed gives the same result on any
    number of threads. A run that diverges is worse than any that does not.

    Args:
        aim: what is to be small.
        ranges: the lowest and highest value of each parameter, by its path, in SI units.
        candidates: how many sets of parameters are tried; rounded up to a multiple of 64.
        seed: of the search.
        threads: how many to use; all cores if None.
        progress: called after each generation.

    Raises:
        ParameterError: an unknown path, a metric that a loop does not have, a range that is none or leaves
            the parameter's own, or no candidate allows a controller.
        HydroservoError: with every candidate some run diverged.

    Warns:
        HydroservoWarning: what is to be known of the runs with the best values, as for simulate_batch.

    Source: Storn, Price, Journal of Global Optimization 11, 1997, doi:10.1023/A:1008202821328.
    Fails to promise the best there is: another seed may find a better one.
    """
    aim = aim._replace(loops=[wired(loop) for loop in aim.loops])
    check(aim, ranges)
    own = [{path: value_at(loop, path) for path in ranges} for loop in aim.loops]
    _, before = at_points(aim, own, threads)
    space = Space(ranges)
    generations = max(1, math.ceil(candidates / CANDIDATES))
    done, best = 0, math.inf

    def generation(units: Numbers) -> Any:
        nonlocal done, best
        values = space.values(units.T)
        found = costs(aim, [objective(aim, i, values, threads) for i in range(len(aim.loops))])
        done, best = done + 1, min(best, found.min())
        if progress is not None:
            progress(done / generations, geometric_mean(best))
        return found

    point = minimum(generation, len(ranges), generations, seed)
    parameters = space.rounded(point)
    tables, after = at_points(aim, [parameters] * len(aim.loops), threads)
    if math.inf in after:
        tried = f"each of {done * CANDIDATES:,} candidates"
        raise HydroservoError(f"nothing found: with {tried} some run diverged; try other ranges")
    for line in dict.fromkeys(line for table in tables for line in warnings_of(table)):
        warnings.warn(line, HydroservoWarning, stacklevel=2)
    return Tuned(
        parameters,
        before,
        after,
        cost=geometric_mean(costs(aim, after)),
        runs=done * CANDIDATES * aim.seeds * len(aim.loops),
        edges=[path for path, unit in zip(ranges, point, strict=True) if not 0.01 < unit < 0.99],
        tables=tables,
    )


def check(aim: Aim, ranges: Mapping[str, tuple[float, float]]) -> None:
    if not aim.loops:
        raise ParameterError("loops", list(aim.loops), "must be at least one")
    known = judged_by(aim.loops)
    if aim.metric not in known:
        raise ParameterError("metric", aim.metric, one_of(aim.metric, known))
    weights = weights_of(aim)
    if len(weights) != len(aim.loops) or not all(0.0 < weight < math.inf for weight in weights):
        raise ParameterError("weights", list(aim.weights), "must be a finite number above 0 for each loop")
    if aim.effort and ACTIVITY not in known:
        raise ParameterError("effort", aim.effort, f"must be 0 for a loop without the metric {ACTIVITY}")
    if aim.seeds < 1:
        raise ParameterError("seeds", aim.seeds, "must be a whole number from 1 on")
    if not 0.0 <= aim.effort < math.inf:
        raise ParameterError("effort", aim.effort, "must be a finite number from 0 on")
    if not ranges:
        raise ParameterError("ranges", "{}", "must name at least one parameter")
    for path, (low, high) in ranges.items():
        for loop in aim.loops:
            try:
                present, field = value_at(loop, path), field_at(loop, path)
            except ParameterError as error:
                raise ParameterError("ranges", path, error.allowed) from None
            if not isinstance(present, float):
                raise ParameterError("ranges", path, "must be the path of a float")
            if not (low < high and within(low, field) and within(high, field)):
                raise ParameterError(path, (low, high), "must be a range of allowed values, low before high")


class Space(NamedTuple):
    """Ranges as a unit cube."""

    ranges: Mapping[str, tuple[float, float]]

    def values(self, units: Numbers) -> dict[str, Numbers]:
        """Parameters by path for points of shape (candidates, paths)."""
        found = {}
        for (path, (low, high)), unit in zip(self.ranges.items(), units.T, strict=True):
            between = low * (high / low) ** unit if low * high > 0.0 else low + (high - low) * unit
            found[path] = np.clip(between, low, high)
        return found

    def rounded(self, unit: Numbers) -> dict[str, float]:
        """Parameters by path for one point of shape (paths,), with few digits."""
        found = {}
        for path, (value,) in self.values(unit[np.newaxis]).items():
            low, high = self.ranges[path]
            found[path] = min(max(float(f"{value:.{DIGITS}g}"), low), high)
        return found


def minimum(cost: Callable[[Numbers], Any], dimensions: int, generations: int, seed: int) -> Numbers:
    """The point of the unit cube at which a function of points of shape (dimensions, points) is smallest."""
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    first = qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(CANDIDATES)
    found = differential_evolution(
        cost,
        [(0.0, 1.0)] * dimensions,
        init=first,
        maxiter=generations - 1,
        tol=0.0,
        atol=-1.0,  # never ends early: every law gets as many candidates
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng([seed, 1]),
    )
    return np.asarray(found.x)


def at_points(
    aim: Aim, points: Sequence[Mapping[str, float]], threads: int | None
) -> tuple[list["xr.Dataset"], list[float]]:
    """The runs of each loop with parameters of its own, and its metric; inf where a run diverged."""
    columns = [{path: np.array([value]) for path, value in point.items()} for point in points]
    tables = [runs_of(aim, i, one, threads) for i, one in enumerate(columns)]
    metrics = [means(aim, i, table).item() for i, table in enumerate(tables)]
    return tables, [one if one < SAFE else math.inf for one in metrics]


def objective(aim: Aim, i: int, candidates: Columns, threads: int | None) -> Numbers:
    """What loop i makes of each candidate; of one that allows no controller, that of a lost run."""
    try:
        runs = runs_of(aim, i, candidates, threads, needed(aim, aim.loops[i]))
        return means(aim, i, runs) * activity(aim, runs)
    except ParameterError:
        count = next(iter(candidates.values())).size
        possible = np.array([is_possible(aim.loops[i], candidates, k) for k in range(count)])
        if possible.all():
            raise
        found = np.full(count, LOST)
        if possible.any():
            kept = {path: values[possible] for path, values in candidates.items()}
            found[possible] = objective(aim, i, kept, threads)
        return found


def needed(aim: Aim, loop: Loop) -> dict[str, Block]:
    """The monitors that a search asks for: others would only take time."""
    wanted = {aim.metric} | ({ACTIVITY} if aim.effort else set())
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
    """The metric of each candidate, mean over the seeds.

    Raises:
        ParameterError: loop i does not have the metric.
    """
    values = runs[aim.metric].values
    lost = runs["diverged"].values | np.isinf(values)
    if np.isnan(values[~lost]).any():
        which = f"loop {i + 1} of {len(aim.loops)}"
        raise ParameterError("metric", aim.metric, f"must be one that every loop has; it is nan in {which}")
    found: Numbers = np.where(lost, LOST, values).reshape(-1, aim.seeds).mean(axis=1)
    return found


def activity(aim: Aim, runs: "xr.Dataset") -> Numbers:
    """The factor that the command's total variation, mean over the seeds, is on a candidate's metric."""
    if not aim.effort:
        return np.ones(runs.sizes["run"] // aim.seeds)
    variation = runs[ACTIVITY].values.reshape(-1, aim.seeds).mean(axis=1)
    known = np.where(np.isfinite(variation), variation, 1.0)
    factor: Numbers = np.maximum(known, CALMEST) ** aim.effort
    return factor


def costs(aim: Aim, metrics: Sequence[Any]) -> Any:
    """What is made small: the logarithm of the loops' geometric mean, and a penalty where a run was lost."""
    bounded = [np.clip(metric, 1.0 / LOST, LOST) for metric in metrics]
    weights = weights_of(aim)
    total = sum(weight * np.log(one) for weight, one in zip(weights, bounded, strict=True))
    return total / sum(weights) + np.where(np.max(metrics, axis=0) < SAFE, 0.0, PENALTY)


def weights_of(aim: Aim) -> Sequence[float]:
    """The weight of each loop."""
    return aim.weights if len(aim.weights) else [1.0] * len(aim.loops)


def geometric_mean(cost: float) -> float:
    """The geometric mean that a cost stands for; inf where a run was lost."""
    return math.exp(cost) if cost < 0.5 * PENALTY else math.inf
