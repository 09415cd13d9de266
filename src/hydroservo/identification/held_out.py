"""Whether what a log says also holds for the part of it that was not asked."""

from typing import NamedTuple

import numpy as np

from hydroservo.identification.misfit import misfit
from hydroservo.identification.problem import Problem
from hydroservo.identification.search import Solution, refined

SHARE = 0.2  # of each segment, its end


class HeldOut(NamedTuple):
    """Root mean squares of weighted residuals.

    Attributes:
        inside: over what was fitted.
        outside: over what was held out.
    """

    inside: float
    outside: float


def held_out(problem: Problem, best: Solution) -> dict[tuple[int, str], HeldOut]:
    """Fit the first four fifths of each segment, and simulate the last: the residuals of both.

    Args:
        problem: what was sought.
        best: the fit to all of it, from which this one starts.

    Returns:
        By log and signal, in the signal's unit.
    """
    counted = {}
    for i, one in enumerate(problem.experiments):
        samples = one.segment.samples
        counted[i] = np.arange(samples) < (1.0 - SHARE) * samples
    part = refined(problem, best.x, best.weights, counted=counted)
    shown = misfit(problem, part.x, best.weights, slopes=False)
    rows: dict[tuple[int, str], list[list[np.ndarray]]] = {}
    for (i, name), place in shown.rows.items():
        key = problem.experiments[i].segment.log, name
        for inside, of in ((True, 0), (False, 1)):
            own = shown.there[place] & (counted[i] == inside)
            rows.setdefault(key, [[], []])[of].append(shown.residuals[place][own] / best.weights[key])
    return {key: HeldOut(*(rms(np.concatenate(parts)) for parts in both)) for key, both in rows.items()}


def rms(values: np.ndarray) -> float:
    """Root of the mean square; nan of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")
