"""Least squares of weighted residuals from several starts, with weights that the residuals give."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError
from hydroservo.identification.experiment import COARSE
from hydroservo.identification.problem import (
    PLACES,
    Problem,
    adapt_steps,
    are_possible,
    delay_of,
    runs_at,
    simulate_segments,
)
from hydroservo.identification.segments import TO_DEVIATION, noise_of
from hydroservo.runs.tuning import latin_hypercube

Vector = NDArray[np.float64]
Weights = Mapping[tuple[int, str], float]  # by log and signal, in the inverse of its unit
Counted = Mapping[int, NDArray[np.bool_]]  # by segment, which samples count
KNEE = 2.0  # deviations, from which a residual counts linearly: 99 % efficient for normal noise
CANDIDATES = 63  # of starts, besides the scenario's own values: two groups of lanes
STARTS = 3
ROUNDS = 4  # of weights
SETTLED = 0.02  # relative change of a weight
LEAST = 1e-9  # of a signal's spread, which its residuals are at least taken to have
EVALUATIONS = 40
FIRST = 20  # of them from each start
SMALL = 0.1  # of a number's deviation, which steps may move it by
ENDED = 1e-6  # relative change of what is left, or of the unknowns
ROUGH = 1e-4  # the same of what is left, from each start: enough to see which one leads on
WEIGHT = 0.1  # of what ranges say, as a measurement around the scenario's values: it decides what logs do not
LEAST_ERROR = 1e-3  # of a signal's spread, which the first fit does not try to get below

Report = Callable[[float], None]

Samples = NDArray[np.float64]


class Misfit(NamedTuple):
    """Residuals, measured less simulated, over all segments, signals and samples."""

    residuals: Vector  # weighted; 0 where nothing was measured. Shape (rows,)
    slopes: Vector  # by each unknown, shape (rows, unknowns)
    rows: Mapping[tuple[int, str], slice]  # of each segment and signal, by both
    there: NDArray[np.bool_]  # which rows were measured


def misfit_at(
    problem: Problem, x: Vector, weights: Weights, counted: Counted | None = None, slopes: bool = True
) -> Misfit:
    """The residuals at a point; nan everywhere if it allows no machine, or the run is lost."""
    rows, start = {}, 0
    for i, one in enumerate(problem.experiments):
        for name in one.segment.measured:
            rows[i, name] = slice(start, start + one.segment.samples)
            start += one.segment.samples
    residuals, there = np.full(start, np.nan), np.zeros(start, dtype=bool)
    table = np.zeros((start, x.size))
    try:
        shown = simulate_segments(problem, x, slopes)
    except (ParameterError, ScenarioError):
        return Misfit(residuals, table, rows, there)
    for (i, name), place in rows.items():
        segment = problem.experiments[i].segment
        weight, measured = weights[segment.log, name], segment.measured[name]
        there[place] = np.isfinite(measured) & (True if counted is None else counted[i])
        apart = measured - shown[i].values[name]
        residuals[place] = np.where(there[place], weight * apart, 0.0)
        table[place] = np.where(there[place, np.newaxis], -weight * shown[i].slopes[name], 0.0)
    return Misfit(residuals, np.nan_to_num(table), rows, there)


def residuals_by_signal(problem: Problem, found: Misfit) -> dict[tuple[int, str], list[Vector]]:
    """The residuals that were measured of each log's signal, a row for each of its segments."""
    every: dict[tuple[int, str], list[Vector]] = {}
    for (i, name), place in found.rows.items():
        key = problem.experiments[i].segment.log, name
        every.setdefault(key, []).append(found.residuals[place][found.there[place]])
    return every


class Solution(NamedTuple):
    """Where a search ended."""

    x: Vector  # the point, in units of the search
    cost: float  # what is left there
    weights: Weights  # of each signal
    evaluations: int  # of residuals and slopes


def best_fit(problem: Problem, seed: int, report: Report) -> tuple[Problem, Solution]:
    """The unknowns that make weighted residuals smallest.

    First each signal counts by its noise, from the scenario's values and from the best of 63 others over the
    ranges; from the best end on each signal counts by the deviation of its residuals, until that settles, and
    residuals beyond two deviations linearly. What the logs do not tell stays near the scenario's values.
    Numbers that are uncertain but not sought are freed once the others are near their best values.

    Automatic steps are coarse at first: as many as the best of all tried machines needs, since others may hit
    end stops that the log never reached and need far more. If the machine found needs finer steps, the search
    continues with these, so that their error is small beside the residuals.

    Source: Huber, Robust Statistics, 1981, ch. 7 (residuals that count linearly); Branch, Coleman, Li, SIAM
    J. Scientific Computing 21, 1999, as scipy.optimize.least_squares has it (bounds).
    Fails to promise the best there is.
    """
    weights = first_weights(problem)
    ends = []
    begin_at, best, residual_share = start_points(problem, weights, seed)
    if problem.automatic:
        easier = adapt_steps(problem, best, max(COARSE, tolerance_for(problem, residual_share)))
        problem, begin_at = with_coarse_steps(problem, easier, begin_at, best, weights)
    pinned = problem._replace(pinned=True)
    for number, x in enumerate(begin_at):
        ends.append(refine(pinned, x, weights, knee=None, tolerance=ROUGH, most=FIRST))
        report(0.6 * (number + 1) / len(begin_at))
    found = min(ends, key=lambda one: one.cost)
    found = found._replace(evaluations=sum(one.evaluations for one in ends))
    found = settle_weights(problem, found, lambda part: report(0.6 + 0.2 * part))
    if problem.automatic:
        least = min(1.0 / (weight * problem.spread[key]) for key, weight in found.weights.items())
        finer = adapt_steps(problem, found.x, tolerance_for(problem, least))
        if total_steps(finer) > total_steps(problem):
            return finer, settle_weights(finer, found, lambda part: report(0.8 + 0.2 * part))
    return problem, found


def with_coarse_steps(
    problem: Problem, easier: Problem, begin_at: list[Vector], best: Vector, weights: Weights
) -> tuple[Problem, list[Vector]]:
    """The problem with other steps, and those starts that are not lost with them.

    Where the best one is, all stays as it was.
    """
    kept = [x for x in begin_at if np.isfinite(misfit_at(easier, x, weights, slopes=False).residuals).all()]
    return (easier, kept) if any(x is best for x in kept) else (problem, begin_at)


def tolerance_for(problem: Problem, share: float) -> float:
    """The tolerance of steps whose error moves no number by more than a tenth of its deviation.

    Worst case: the error follows a slope through all n samples, and then counts the root of n times.
    """
    return SMALL * share / math.sqrt(sum(one.segment.samples for one in problem.experiments))


def total_steps(problem: Problem) -> int:
    """How many steps all segments take together."""
    return sum(one.loop.simulation.substeps * one.segment.samples for one in problem.experiments)


def settle_weights(problem: Problem, found: Solution, report: Report) -> Solution:
    """The optimum near another, each signal counting by the deviation of its own residuals."""
    evaluations = found.evaluations
    for number in range(ROUNDS):
        renewed = weights_at(problem, misfit_at(problem, found.x, found.weights, slopes=False), found.weights)
        change = max(abs(renewed[key] / found.weights[key] - 1.0) for key in renewed)
        if number and change < SETTLED:
            break
        found = refine(problem, found.x, renewed)
        evaluations += found.evaluations
        report((number + 1) / ROUNDS)
    return found._replace(evaluations=evaluations)


def refine(
    problem: Problem,
    x: Vector,
    weights: Weights,
    knee: float | None = KNEE,
    counted: dict[int, NDArray[np.bool_]] | None = None,
    tolerance: float = ENDED,
    most: int = EVALUATIONS,
) -> Solution:
    """The nearest local optimum.

    Residuals count linearly beyond the knee, or nowhere if it is None.
    """
    from scipy.optimize import least_squares

    last: list[tuple[Vector, Misfit]] = []

    def at(point: Vector) -> Misfit:
        if not last or not np.array_equal(last[0][0], point):
            last[:] = [(point.copy(), misfit_at(problem, point, weights, counted))]
        return last[0][1]

    low, high = problem.bounds
    pull = np.sqrt([(1.0 if one.kind == "uncertain" else WEIGHT) * one.prior for one in problem.unknowns])
    if not np.isfinite(at(x).residuals).all():
        raise HydroservoError("a run with these parameters diverges; try other ranges")
    found = least_squares(
        lambda point: np.concatenate([at(point).residuals, pull * (point - problem.usual)]),
        np.clip(x, low, high),
        jac=lambda point: np.vstack([at(point).slopes, np.diag(pull)]),
        bounds=(low, high),
        x_scale="jac",
        loss="linear" if knee is None else "huber",
        f_scale=knee or 1.0,
        ftol=tolerance,
        xtol=ENDED,
        gtol=None,
        max_nfev=most,
    )
    return Solution(found.x, float(found.cost), weights, int(found.nfev))


def first_weights(problem: Problem) -> dict[tuple[int, str], float]:
    """The inverse of each signal's noise, as far as it can be told before there is a model."""
    noise: dict[tuple[int, str], list[float]] = {}
    for one in problem.experiments:
        for name, values in one.segment.measured.items():
            noise.setdefault((one.segment.log, name), []).append(noise_of(values))
    return {key: 1.0 / max(*found, LEAST_ERROR * problem.spread[key]) for key, found in noise.items()}


def start_points(problem: Problem, weights: Weights, seed: int) -> tuple[list[Vector], Vector, float]:
    """Where to begin: the scenario's own values, and the best of others, each with the delay that it shows.

    Returned with them are the best one, and the share of the signals' spread that it leaves.
    """
    own, count = problem.usual, len(problem.space.ranges) - len(problem.uncertain)
    points = np.repeat(own[np.newaxis], 1 + CANDIDATES, axis=0)
    points[1:, :count] = latin_hypercube(CANDIDATES, count, seed)
    points = points[are_possible(problem, points)]
    if not points.size:
        raise HydroservoError("no parameters within their ranges make a valid machine; try other ranges")
    cost = np.zeros(len(points))
    for number, one in enumerate(problem.experiments):
        shown = runs_at(problem, points, number)
        place, log = delay_of(problem, one.segment.log), one.segment.log
        scaled = {name: weight for (number_of_log, name), weight in weights.items() if number_of_log == log}
        late = problem.unknowns[place]
        least, most = math.ceil(late.low), math.floor(late.high)
        for run, point in enumerate(points):
            own_signals = {name: shown[:, index, run] for name, index in PLACES.items()}
            measured = one.segment.measured
            point[place] = best_lag(measured, own_signals, scaled, least, max(least, most))
            cost[run] += remaining_variance(measured, own_signals, scaled, int(point[place]))
    if not np.isfinite(cost).any():
        raise HydroservoError("a run diverges with each of the parameters tried; try other ranges")
    order = [0, *(1 + np.argsort(cost[1:]))][:STARTS]
    finite = {i: points[i] for i in order if np.isfinite(cost[i])}
    first = min(finite, key=lambda i: cost[i])
    whole = sum(
        (weights[one.segment.log, name] * problem.spread[one.segment.log, name]) ** 2
        for one in problem.experiments
        for name in one.segment.measured
    )
    return list(finite.values()), finite[first], math.sqrt(cost[first] / whole)


def weights_at(problem: Problem, found: Misfit, weights: Weights) -> Weights:
    """The inverse of each signal's deviation, from the median of its residuals."""
    renewed = {}
    for key, parts in residuals_by_signal(problem, found).items():
        deviation = TO_DEVIATION * float(np.median(np.abs(np.concatenate(parts)))) / weights[key]
        renewed[key] = 1.0 / max(deviation, LEAST * problem.spread[key])
    return renewed


def best_lag(
    measured: Mapping[str, Samples],
    shown: Mapping[str, Samples],
    weights: Mapping[str, float],
    least: int,
    most: int,
) -> int:
    """The whole number of samples by which measured signals come after simulated ones: what leaves least."""
    every = [
        weights[name] ** 2 * lag_variances(one, shown[name], least, most) for name, one in measured.items()
    ]
    total = np.sum(every, axis=0)
    return least + int(np.argmin(np.where(np.isfinite(total), total, np.inf)))


def remaining_variance(
    measured: Mapping[str, Samples], shown: Mapping[str, Samples], weights: Mapping[str, float], shift: int
) -> float:
    """The weighted squares of the differences at a lag, a signal's mean difference left out; inf if lost.

    A simulated signal is held before its first and after its last sample, as the search has it.
    """
    total = 0.0
    for name, values in measured.items():
        places = np.clip(np.arange(values.size) - shift, 0, values.size - 1)
        apart = (values - shown[name][places])[np.isfinite(values)]
        total += weights[name] ** 2 * float(np.var(apart))
    return total if np.isfinite(total) else np.inf


def lag_variances(measured: Samples, shown: Samples, least: int, most: int) -> Samples:
    """The variance of a difference at each lag, by Fourier transforms of the correlations in it."""
    before, after = max(most, 0), max(-least, 0)
    there = np.isfinite(measured).astype(np.float64)
    own = np.where(there > 0.0, measured, 0.0) - there * np.nanmean(measured)
    held = np.pad(shown - shown.mean(), (before, after), mode="edge")
    spectra = np.conj(np.fft.rfft([there, own], held.size))
    first, second = np.fft.rfft([held, held**2])
    products = [first * spectra[0], second * spectra[0], first * spectra[1]]
    sums, squares, products_of = np.fft.irfft(products, held.size)[:, before - np.arange(least, most + 1)]
    count = there.sum()
    return np.asarray(((own**2).sum() - 2.0 * products_of + squares) / count - (sums / count) ** 2)
