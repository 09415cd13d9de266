"""The best gains of a loop, by a search that treats every law alike."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.batch import simulate_batch
from hydroservo.block import field_at
from hydroservo.checks import within
from hydroservo.errors import ParameterError
from hydroservo.loop import Loop
from hydroservo.metrics import FLAGS, METRIC_FIELDS
from hydroservo.varied import SEED

__all__ = ["LOST", "Aim", "Tuned", "measured", "tune"]

Numbers = NDArray[np.float64]
Progress = Callable[[float, float], None]  # called with the fraction done and the best cost so far

LOST = 1e6  # counts as the metric of a run that diverged, in the metric's unit
CANDIDATES = 64  # of a generation: two groups of lanes


class Aim(NamedTuple):
    """What is to be small: the weighted geometric mean of a metric over loops, each its mean over seeds.

    Attributes:
        loops: the loops, all with the same controller.
        weights: of each loop's metric in the geometric mean.
        metric: name of the metric.
        seeds: how many seeds each candidate is simulated with, from the loop's own on.
    """

    loops: Sequence[Loop]
    weights: Sequence[float]
    metric: str = "rms_error"
    seeds: int = 1


class Tuned(NamedTuple):
    """What a search found.

    Attributes:
        parameters: the best values by path, in SI units.
        metrics: the metric of each loop with them, mean over the seeds.
        cost: the weighted geometric mean of these.
        runs: how many closed loops were simulated.
        edges: the paths whose best value lies within a hundredth of an end of its range.
    """

    parameters: Mapping[str, float]
    metrics: Sequence[float]
    cost: float
    runs: int
    edges: Sequence[str]


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
    range does not touch 0, in the parameter itself otherwise. The same seed gives the same result on any
    number of threads. Runs that diverge count as a metric of 1e6.

    Args:
        aim: what is to be small.
        ranges: the lowest and highest value of each parameter, by its path, in SI units.
        candidates: how many sets of parameters are tried; a multiple of 64 is taken.
        seed: of the search.
        threads: how many to use; all cores if None.
        progress: called after each generation.

    Raises:
        ParameterError: an unknown path or metric, a range that is none or leaves the parameter's own.

    Source: Storn, Price, Journal of Global Optimization 11, 1997, doi:10.1023/A:1008202821328.
    Fails to promise the best there is: another seed may find a better one.
    """
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    check(aim, ranges)
    space = Space(ranges)
    generations = max(1, math.ceil(candidates / CANDIDATES) - 1)
    done = 0

    def cost(units: Numbers) -> Any:
        nonlocal done
        found = mean_log(aim, measured(aim, space.values(units.T), threads))
        done += 1
        if progress is not None:
            progress(min(1.0, done / (generations + 1)), math.exp(found.min()))
        return found

    first = qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(seed)).random(CANDIDATES)
    best = differential_evolution(
        cost,
        [(0.0, 1.0)] * len(ranges),
        init=first,
        maxiter=generations,
        tol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng([seed, 1]),
    )
    parameters = {path: float(value[0]) for path, value in space.values(best.x[np.newaxis]).items()}
    metrics = [float(one[0]) for one in measured(aim, space.values(best.x[np.newaxis]), threads)]
    edges = [path for path, unit in zip(ranges, best.x, strict=True) if not 0.01 < unit < 0.99]
    runs = done * CANDIDATES * aim.seeds * len(aim.loops)
    return Tuned(parameters, metrics, math.exp(mean_log(aim, metrics)), runs, edges)


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


def check(aim: Aim, ranges: Mapping[str, tuple[float, float]]) -> None:
    numbers = [name for name in METRIC_FIELDS if name not in FLAGS]
    if aim.metric not in numbers:
        raise ParameterError("metric", aim.metric, f"must be one of {', '.join(numbers)}")
    if len(aim.weights) != len(aim.loops) or not all(weight > 0.0 for weight in aim.weights):
        raise ParameterError("weights", list(aim.weights), f"must be {len(aim.loops)} numbers above 0")
    if not ranges:
        raise ParameterError("ranges", "{}", "must name at least one parameter")
    for path, (low, high) in ranges.items():
        for loop in aim.loops:
            try:
                field = field_at(loop, path)
            except KeyError as error:
                raise ParameterError("ranges", path, error.args[0]) from None
            if not (low < high and within(low, field) and within(high, field)):
                raise ParameterError(path, (low, high), "must be a range of allowed values, low before high")


def mean_log(aim: Aim, metrics: Sequence[Any]) -> Any:
    """The logarithm of the weighted geometric mean of the loops' metrics."""
    total = sum(weight * np.log(metric) for weight, metric in zip(aim.weights, metrics, strict=True))
    return total / sum(aim.weights)


def measured(aim: Aim, parameters: Mapping[str, Numbers], threads: int | None) -> list[Numbers]:
    """The metric of each candidate in each loop, mean over the seeds.

    Args:
        aim: what is measured.
        parameters: values of shape (candidates,) by path; none for the loops as they are.
        threads: how many to use; all cores if None.
    """
    count = next((values.size for values in parameters.values()), 1)
    found = []
    for loop in aim.loops:
        columns: dict[str, Any] = {path: np.repeat(values, aim.seeds) for path, values in parameters.items()}
        columns[SEED] = np.tile(loop.simulation.seed + np.arange(aim.seeds), count)
        runs = simulate_batch(loop, columns, threads=threads)
        values = runs[aim.metric].values.astype(np.float64)
        lost = runs["diverged"].values | ~np.isfinite(values)
        found.append(np.where(lost, LOST, np.minimum(values, LOST)).reshape(count, aim.seeds).mean(axis=1))
    return found
