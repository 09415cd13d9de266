"""Which numbers the logs tell, and which they do not."""

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.misfit import Weights
from hydroservo.identification.problem import PLACES, Problem, are_possible, delay_of, runs_at
from hydroservo.identification.search import KNEE
from hydroservo.identification.shift import shifted
from hydroservo.identification.uncertainty import NORMAL, Uncertainty

SURE, UNSURE = 0.005, 0.1  # of a range: deviations of a direction that is told for sure, and of one not
BENT = (0.25, 4.0)  # times what it should be that a loss may be at the end of an interval
SHARE = 0.1  # of a variance that may come from directions that are not told
WIDEST = 0.5  # of its range, that an interval may be wide

Matrix = NDArray[np.float64]


def identifiable(problem: Problem, x: Matrix, weights: Weights, sure: Uncertainty) -> NDArray[np.bool_]:
    """Which of the parameters the logs tell, shape (parameters,).

    One is told if its 95 % interval is at most half of its range, and hardly any of its variance, or next to
    nothing of its range, comes from directions, mixtures of all that is sought, which the logs do not tell:
    that leave more than a tenth of a range as a deviation, or along which what is lost by going to an end of
    the interval, simulated there, is not between a quarter and four times what slopes at the optimum say, so
    that the interval means nothing.
    Numbers that are uncertain but not sought go along with each direction as the logs want it.

    Args:
        problem: what was sought.
        x: the optimum, in units of the search.
        weights: of each signal there.
        sure: the covariance there.

    An uncertain number counts as told where its interval is at most half of its uncertainty.
    """
    sought = np.array([one.kind != "uncertain" for one in problem.unknowns])
    along = following(problem, sure.information, sought)
    ranges = np.sqrt([12.0 / one.prior for one in problem.unknowns])[sought]
    prior = np.diag([0.0 if own else one.prior for one, own in zip(problem.unknowns, sought, strict=True)])
    information = along.T @ (sure.information + prior) @ along * np.outer(ranges, ranges)
    values, vectors = np.linalg.eigh(information + 12.0 * np.eye(ranges.size))
    deviations = 1.0 / np.sqrt(np.maximum(values, 12.0))  # the least there is; large ones round it
    steps = along @ (NORMAL * deviations * vectors * ranges[:, np.newaxis])
    untold = (deviations > UNSURE) | ~straight(
        problem, x, weights, steps, sure.information, deviations > SURE
    )
    shares = vectors**2 / values
    doubtful = shares[:, untold].sum(axis=1) / shares.sum(axis=1)
    told = 2.0 * NORMAL * sure.deviations <= WIDEST
    part = sure.deviations[sought] * np.sqrt(doubtful)
    told[sought] &= (doubtful < SHARE) | (part < SURE)
    found: NDArray[np.bool_] = told[: len(problem.space.ranges)]
    return found


def following(problem: Problem, information: Matrix, sought: NDArray[np.bool_]) -> Matrix:
    """How all unknowns move with those sought, the others at their best; shape (unknowns, sought)."""
    along = np.eye(sought.size)[:, sought]
    if not sought.all():
        prior = np.diag([one.prior for one in problem.unknowns])
        own = (information + prior)[np.ix_(~sought, ~sought)]
        along[~sought] = -np.linalg.solve(own, information[np.ix_(~sought, sought)])
    return along


def straight(
    problem: Problem,
    x: Matrix,
    weights: Weights,
    steps: Matrix,
    information: Matrix,
    asked: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Whether what is left grows along each step, one way or the other, as slopes at the optimum say.

    A way that leads out of a range is not gone; a step of which both do is not straight.
    """
    low, high = problem.bounds
    found = ~asked
    points, ways = [x], []
    for k in np.flatnonzero(asked):
        for way in (steps[:, k], -steps[:, k]):
            point = x + way
            if ((point >= low) & (point <= high)).all() and are_possible(problem, point[np.newaxis]).all():
                points.append(point)
                ways.append((k, 0.5 * way @ information @ way))
    left = losses(problem, np.array(points), weights)
    bad = set()
    for (k, expected), one in zip(ways, left[1:], strict=True):
        found[k] = True
        if not BENT[0] * expected < one - left[0] < BENT[1] * expected:
            bad.add(k)
    found[sorted(bad)] = False
    return found


def losses(problem: Problem, points: Matrix, weights: Weights) -> Matrix:
    """What is left at some points of shape (points, unknowns), where residuals count as in the search."""
    total = np.zeros(len(points))
    offsets = {
        (one.where, one.key): (i, one.scale) for i, one in enumerate(problem.unknowns) if one.kind == "offset"
    }
    for number, one in enumerate(problem.experiments):
        shown = runs_at(problem, points, number)
        late = points[:, delay_of(problem, one.segment.log)]
        shown = np.stack([shifted(shown[:, :, k], delay, one.whole) for k, delay in enumerate(late)], axis=2)
        for name, measured in one.segment.measured.items():
            values = shown[:, PLACES[name], :]
            if (one.segment.log, name) in offsets:
                i, scale = offsets[one.segment.log, name]
                values = values + scale * points[:, i]
            size = np.abs(weights[one.segment.log, name] * (measured[:, np.newaxis] - values))
            rho = np.where(size <= KNEE, 0.5 * size**2, KNEE * (size - 0.5 * KNEE))
            total += np.nansum(np.where(np.isnan(values), np.inf, rho), axis=0)
    return total
