"""Least squares of many small problems side by side, each with the bits that it has alone.

All arithmetic goes number by number in a fixed order, so that neither the number of problems nor the
processor changes a bit; LAPACK's last digits depend on both.
"""

from collections.abc import Callable
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Which = NDArray[np.intp]
Residuals = Callable[[Numbers, Which], Numbers]

NUDGE = 2.0**-30  # of a number, or of 1: short enough for orifices that bend near a vanishing drop
FIRST_DAMPING, LEAST_DAMPING = 1e-2, 1e-14  # relative to the slopes
WORSE = 16.0  # how much more after a step that is of no use
IDLE = 1e-8  # change of the cost by a step, relative: a search ends that does not get on
ROUNDS = 300


class Point(NamedTuple):
    """Where problems stand; all arrays have them along their last axis.

    Attributes:
        x: numbers that are sought.
        residuals: there.
        slopes: of each residual, by each number.
        cost: sum of the squares of the residuals.
    """

    x: Numbers
    residuals: Numbers
    slopes: Numbers
    cost: Numbers


@np.errstate(all="ignore")  # a step that is not finite is of no use
def least_squares(residuals: Residuals, count: int, problems: int, settled: float) -> Point:
    """Points near x = 0 at which the sums of the squares of residuals are least.

    By Levenberg and Marquardt: (J'J + d diag(J'J)) step = -J'r. The damping d falls after a step that keeps
    what it promised, and rises after others. A number with no slopes stays 0.

    Args:
        residuals: at points of shape (numbers, points, problems), of the problems with these numbers.
        count: how many numbers are sought.
        problems: how many there are.
        settled: a search whose residuals are all below it ends with the first step that is of no use.

    Source: Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11, 1963.
    """
    going, damping = np.arange(problems), np.full(problems, FIRST_DAMPING)
    at = point(residuals, np.zeros((count, problems)), going)
    for _ in range(ROUNDS):
        here = Point(*(part[..., going] for part in at))
        step, promised = damped_step(here, damping[going])
        new = point(residuals, here.x + step, going)
        gain = (here.cost - new.cost) / promised
        better = new.cost < here.cost
        for part, found in zip(at, new, strict=True):
            part[..., going[better]] = found[..., better]
        kept = np.where(gain > 0.75, 0.1, np.where(gain > 0.25, 1.0, 4.0))
        damping[going] = np.maximum(damping[going] * np.where(better, kept, WORSE), LEAST_DAMPING)
        near = np.abs(at.residuals[:, going]).max(axis=0, initial=0.0) < settled
        idle = np.abs(new.cost - here.cost) < IDLE * here.cost
        going = going[~(idle | near & ~better)]
        if not going.size:
            break
    return at


def point(residuals: Residuals, x: Numbers, which: Which) -> Point:
    """The residuals at x and their slopes, from forward differences."""
    nudges, count = NUDGE * np.maximum(np.abs(x), 1.0), len(x)
    points = np.repeat(x[:, np.newaxis], count + 1, axis=1)
    points[range(count), range(1, count + 1)] += nudges
    found = residuals(points, which)
    base = found[:, 0]
    return Point(x, base, (found[:, 1:] - found[:, :1]) / nudges, total(base * base))


def damped_step(at: Point, damping: Numbers) -> tuple[Numbers, Numbers]:
    """A step from a point, and by how much the cost falls with it if the slopes stay.

    The matrix is positive definite, so that elimination needs no pivots.
    """
    slopes, n = at.slopes, range(len(at.x))
    table = np.empty((len(n), len(n) + 1, len(damping)))
    table[:, :-1] = total(slopes[:, :, np.newaxis] * slopes[:, np.newaxis])
    table[:, -1] = pull = -total(slopes * at.residuals[:, np.newaxis])
    added = damping * np.where(table[n, n] > 0.0, table[n, n], 1.0)
    table[n, n] += added
    for k in n:
        row = table[k] / table[k, k]
        table -= table[:, k, np.newaxis] * row
        table[k] = row
    step = table[:, -1]
    return step, total(step * (added * step + pull))


def total(terms: Numbers) -> Numbers:
    """The sum over the first axis, one term after the other."""
    return reduce(np.add, terms, np.zeros(terms.shape[1:]))
