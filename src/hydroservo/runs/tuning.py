"""The best gains of a loop, by a search that treats every law alike."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, value_at
from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.formatting import column, quantity
from hydroservo.html_tables import Strong, html_remarks, html_table
from hydroservo.loop import Loop
from hydroservo.metrics import declared_metrics, monitors_of
from hydroservo.runs.aims import ACTIVITY, Aim, check_ranges, checked_aim, checked_whole
from hydroservo.runs.arguments import checked_loops
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.columns import SEED, checked_columns, designs, starts
from hydroservo.runs.run import with_metrics
from hydroservo.validation import checked
from hydroservo.wiring import wired

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CANDIDATES", "Progress", "Space", "Tuned", "is_possible", "minimum", "needed", "searched"]

Numbers = NDArray[np.float64]
Columns = Mapping[str, Numbers]
Progress = Callable[[float, float], None]  # called with the fraction done and the best geometric mean so far

LOST = 1e30  # counts as the metric of a run that diverged: beyond that of any other, in whatever unit
SAFE = 1e20  # a mean over seeds is below this unless it counts a lost run
CANDIDATES = 64  # of a generation: whole groups of lanes
PENALTY = 400.0  # on the cost of a lost run: more than metrics between 1/LOST and LOST can differ by
CALMEST = 1e-6  # [V] a command that varies less is not worth more
DIGITS = 5  # of what is found; a rig's gains have no more


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
        names: of the loops.
        metric: what was made small.
        unstable: names of loops that the best values leave unstable for small motions about their operating
            point.
    """

    parameters: Mapping[str, float]
    before: Sequence[float]
    after: Sequence[float]
    cost: float
    runs: int
    edges: Sequence[str]
    tables: Sequence[Any]  # datasets of xarray, which is heavy to import
    names: Sequence[str]
    metric: str
    unstable: Sequence[str] = ()

    def __repr__(self) -> str:
        lines = [f"{path} = {value:g}" for path, value in self.parameters.items()]
        metrics = zip(self.names, self.before, self.after, strict=True)
        lines += [f"{name}: {before:.3g} -> {after:.3g}" for name, before, after in metrics]
        edges = f"; at an end of its range: {', '.join(self.edges)}" if self.edges else ""
        unstable = f"; unstable for small motions: {'; '.join(self.unstable)}" if self.unstable else ""
        return "\n".join([*lines, f"{self.runs} closed loops were simulated{edges}{unstable}"])

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        about = {path: self.tables[0][path].attrs for path in self.parameters}
        values = [
            (path, Strong(quantity(value, about[path]["units"])), about[path]["long_name"])
            for path, value in self.parameters.items()
        ]
        unit = self.tables[0][self.metric].attrs["units"]
        label, each = column([*self.before, *self.after], unit)
        count = len(self.before)
        metrics = zip(self.names, each[:count], map(Strong, each[count:]), strict=True)
        heads = ("loop", f"{self.metric} before [{label}]", "after")
        remarks = [Strong(f"at an end of its range: {path}") for path in self.edges]
        remarks += [Strong(f"unstable for small motions: {name}") for name in self.unstable]
        runs = f"{self.runs:,} closed loops were simulated"
        return (
            html_table(("parameter", "best", "meaning"), values)
            + html_table(heads, metrics)
            + html_remarks([*remarks, runs])
        )


def searched(
    aim: Aim,
    ranges: Mapping[str, tuple[float, float]],
    candidates: int,
    seed: int,
    threads: int | None,
    progress: Progress | None,
) -> Tuned:
    """Search the parameters of loops that make a metric smallest.

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
            the parameter's own, a number out of its range, no candidate makes a valid controller, or the
            metric is 0 with all of them.
        HydroservoError: with every candidate some run diverged.

    Source: Storn, Price, Journal of Global Optimization 11, 1997, doi:10.1023/A:1008202821328.
    Fails to promise the best there is: another seed may find a better one.
    """
    loops = [with_metrics(loop, aim.metrics) for loop in checked_loops(aim.loops)]
    aim = checked_aim(aim._replace(loops=[wired(loop) for loop in loops]))
    check_ranges(aim.loops, ranges)
    candidates, seed = checked_whole("candidates", candidates), checked_whole("seed", seed)
    own = [{path: value_at(loop, path) for path in ranges} for loop in aim.loops]
    _, before = at_points(aim, own, threads)
    space = Space(ranges)
    generations = math.ceil(candidates / CANDIDATES)
    done, best, worst = 0, math.inf, 0.0

    def generation(units: Numbers) -> Any:
        nonlocal done, best, worst
        values = space.values(units.T)
        metrics = [objective(aim, i, values, threads) for i in range(len(aim.loops))]
        found = costs(aim, metrics)
        done, best, worst = done + 1, min(best, found.min()), max(worst, np.max(metrics))
        if progress is not None:
            progress(done / generations, mean_of(best))
        return found

    point = minimum(generation, len(ranges), generations, seed)
    if worst == 0.0:
        problem = f"is 0 with each of {done * CANDIDATES:,} candidates, which says nothing; use another"
        raise ParameterError("metric", aim.metric, problem)
    parameters = space.rounded(point)
    tables, after = at_points(aim, [parameters] * len(aim.loops), threads)
    if math.inf in after:
        tried = f"each of {done * CANDIDATES:,} candidates"
        raise HydroservoError(f"nothing found: with {tried} some run diverged; try other ranges")
    return Tuned(
        parameters,
        before,
        after,
        cost=mean_of(costs(aim, after)),
        runs=done * CANDIDATES * aim.seeds * len(aim.loops),
        edges=[path for path, unit in zip(ranges, point, strict=True) if not 0.01 < unit < 0.99],
        tables=tables,
        names=[f"loop {i}" for i in range(1, len(aim.loops) + 1)],
        metric=aim.metric,
    )


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
        wanted = {aim.metric} | ({ACTIVITY} if aim.effort else set())
        runs = runs_of(aim, i, candidates, threads, needed(aim.loops[i], wanted))
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
    total = sum(weight * np.log(one) for weight, one in zip(aim.weights, bounded, strict=True))
    return total / math.fsum(aim.weights) + np.where(np.max(metrics, axis=0) < SAFE, 0.0, PENALTY)


def mean_of(cost: float) -> float:
    """The geometric mean that a cost stands for; inf where a run was lost."""
    return math.exp(cost) if cost < 0.5 * PENALTY else math.inf
