"""Weighted residuals of logs, and their slopes, at a point of the search."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ParameterError, ScenarioError
from hydroservo.identification.problem import Problem, simulated

Vector = NDArray[np.float64]
Weights = Mapping[tuple[int, str], float]  # by log and signal, in the inverse of its unit
Counted = Mapping[int, NDArray[np.bool_]]  # by segment, which samples count


class Misfit(NamedTuple):
    """Residuals, measured less simulated, over all segments, signals and samples.

    Attributes:
        residuals: weighted; 0 where nothing was measured. Shape (rows,).
        slopes: by each unknown, shape (rows, unknowns).
        rows: of each segment and signal, by both.
        there: which rows were measured.
    """

    residuals: Vector
    slopes: Vector
    rows: Mapping[tuple[int, str], slice]
    there: NDArray[np.bool_]


def misfit(
    problem: Problem, x: Vector, weights: Weights, counted: Counted | None = None, slopes: bool = True
) -> Misfit:
    """The residuals at a point; nan everywhere if it allows no machine, or the run is lost.

    Args:
        problem: what is sought.
        x: the point, in units of the search.
        weights: of each signal.
        counted: which samples count, of segments in which not all do.
        slopes: False leaves these 0.
    """
    rows, start = {}, 0
    for i, one in enumerate(problem.experiments):
        for name in one.segment.measured:
            rows[i, name] = slice(start, start + one.segment.samples)
            start += one.segment.samples
    residuals, there = np.full(start, np.nan), np.zeros(start, dtype=bool)
    table = np.zeros((start, x.size))
    try:
        shown = simulated(problem, x, slopes)
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
