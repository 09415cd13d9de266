"""How sure what was found is, and which numbers the logs tell."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.observer import shift_signals
from hydroservo.identification.problem import PLACES, Problem, are_possible, delay_of, runs_at
from hydroservo.identification.regression import NORMAL, long_run_covariance
from hydroservo.identification.search import KNEE, Misfit, Weights

BLOCKS = 50  # of all segments together, at least; they are resampled whole
DRAWS = 500

Matrix = NDArray[np.float64]
SURE, UNSURE = 0.005, 0.1  # of a range: deviations of a direction that is told for sure, and of one not
BENT = (0.25, 4.0)  # times what it should be that a loss may be at the end of an interval
SHARE = 0.1  # of a variance that may come from directions that are not told
WIDEST = 0.5  # of its range, that an interval may be wide


class Uncertainty(NamedTuple):
    """How sure the unknowns are, in units of the search."""

    covariance: Matrix  # of all, what their ranges say counting as a measurement, shape (unknowns, unknowns)
    information: Matrix  # what the logs alone say, shape (unknowns, unknowns)
    resampled: Matrix  # the deviations over resampled stretches of the logs, shape (unknowns,)

    @property
    def deviations(self) -> Matrix:
        """Standard deviations, shape (unknowns,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlations(self) -> Matrix:
        """Correlations, shape (unknowns, unknowns)."""
        return self.covariance / np.outer(self.deviations, self.deviations)


def uncertainty(problem: Problem, found: Misfit, seed: int) -> Uncertainty:
    """The covariance at an optimum, from slopes and residuals there::

        cov = A^-1 B A^-1,   A = sum of J' psi'(r) J + L,   B = cov(sum of J' psi(r)) + L

    with the weighted residuals r, their slopes J and the function psi that leaves residuals up to two
    deviations and cuts the rest; L says of each unknown only that it is in its range. B knows the residuals'
    autocorrelation, so that residuals which hang together, as where the model misses something, widen what
    is found. That is asked of what each sample does to each unknown, A^-1 J' psi(r), and not of the scores,
    of which mixtures nearly cancel: there, small errors of autocorrelations would make large ones.
    No number is surer than white noise would leave it: of an unknown that a few samples tell, as a state at
    the start, B sees too little, for the fit has gone through these.

    As a check, blocks of the logs are drawn with replacement, and what the unknowns would be then follows
    from one step of Newton's method.

    Source: Huber, Robust Statistics, 1981, sec. 7.6 (the covariance); White, Econometrica 50, 1982,
    doi:10.2307/1912526 (that it holds where the model is not quite right); Kunsch, Annals of Statistics 17,
    1989 (blocks).
    Fails where the unknowns are so unsure that slopes change over their intervals.
    """
    prior = np.diag([one.prior for one in problem.unknowns])
    scores, bends = segment_scores(problem, found)
    information = sum((bend.sum(axis=0) for bend in bends), np.zeros_like(prior))
    inverse = np.linalg.inv(information + prior)
    rows, unknowns = int(found.there.sum()), len(problem.unknowns)
    few = rows / max(rows - unknowns, 1)
    apart = measurement_spacing(problem)
    influence = [group_sums(one, apart) @ inverse for one in scores]
    covariance = few * long_run_covariance(influence) + inverse @ prior @ inverse
    wider = np.sqrt(np.maximum(np.diag(inverse) / np.diag(covariance), 1.0))
    covariance = 0.5 * (covariance + covariance.T) * np.outer(wider, wider)
    return Uncertainty(covariance, information, resampled_deviations(scores, bends, prior, seed))


def segment_scores(problem: Problem, found: Misfit) -> tuple[list[Matrix], list[Matrix]]:
    """Of each segment the scores at each sample, and the information of each of its blocks.

    Blocks are as many samples of all signals.
    """
    scores, bends = [], []
    total = sum(one.segment.samples for one in problem.experiments)
    for i, one in enumerate(problem.experiments):
        samples = one.segment.samples
        own = np.zeros((samples, len(problem.unknowns)))
        count = max(round(BLOCKS * samples / total), 2)
        edges = np.linspace(0, samples, count + 1).astype(int)
        bend = np.zeros((count, own.shape[1], own.shape[1]))
        for name in one.segment.measured:
            place = found.rows[i, name]
            residuals, slopes = found.residuals[place], found.slopes[place]
            own -= np.clip(residuals, -KNEE, KNEE)[:, np.newaxis] * slopes
            inside = slopes * (np.abs(residuals) < KNEE)[:, np.newaxis]
            for k in range(count):
                part = inside[edges[k] : edges[k + 1]]
                bend[k] += part.T @ part
        scores.append(own)
        bends.append(bend)
    return scores, bends


def measurement_spacing(problem: Problem) -> int:
    """Of the signal that was measured most rarely, how many samples lie from one measurement to the next."""
    every = [values for one in problem.experiments for values in one.segment.measured.values()]
    there = [np.flatnonzero(np.isfinite(values)) for values in every]
    return max((int(np.median(np.diff(places))) for places in there if places.size > 1), default=1)


def group_sums(rows: Matrix, size: int) -> Matrix:
    """The sums of ``size`` rows each, so that a signal that was measured more rarely is in each of them."""
    return rows if size == 1 else np.add.reduceat(rows, np.arange(0, len(rows), size), axis=0)


def resampled_deviations(
    scores: Sequence[Matrix], bends: Sequence[Matrix], prior: Matrix, seed: int
) -> Matrix:
    """The deviations that the middle 95 % of draws of blocks with replacement show."""
    sums = np.concatenate([block_sums(one, len(bend)) for one, bend in zip(scores, bends, strict=True)])
    every = np.concatenate(bends)
    rng = np.random.default_rng(seed)
    counts = rng.multinomial(len(every), np.full(len(every), 1.0 / len(every)), size=DRAWS)
    steps = counts @ (sums - sums.mean(axis=0))
    bent = np.tensordot(counts, every, axes=1) + prior
    moved = np.linalg.solve(bent, steps[:, :, np.newaxis])[:, :, 0]
    low, high = np.percentile(moved, (2.5, 97.5), axis=0)
    found: Matrix = (high - low) / (2.0 * NORMAL)
    return found


def block_sums(rows: Matrix, count: int) -> Matrix:
    """The sums of rows over so many blocks, shape (count, numbers)."""
    edges = np.linspace(0, len(rows), count + 1).astype(int)
    return np.add.reduceat(rows, edges[:-1], axis=0)


def are_identifiable(problem: Problem, x: Matrix, weights: Weights, sure: Uncertainty) -> NDArray[np.bool_]:
    """Which of the parameters the logs tell, shape (parameters,).

    One is told if its 95 % interval is at most half of its range, and hardly any of its variance, or next to
    nothing of its range, comes from directions, mixtures of all that is sought, which the logs do not tell:
    that leave more than a tenth of a range as a deviation, or along which what is lost by going to an end of
    the interval, simulated there, is not between a quarter and four times what slopes at the optimum say, so
    that the interval means nothing.
    Numbers that are uncertain but not sought go along with each direction as the logs want it.

    An uncertain number counts as told where its interval is at most half of its uncertainty.
    """
    sought = np.array([one.kind != "uncertain" for one in problem.unknowns])
    along = following_directions(problem, sure.information, sought)
    ranges = np.sqrt([12.0 / one.prior for one in problem.unknowns])[sought]
    prior = np.diag([0.0 if own else one.prior for one, own in zip(problem.unknowns, sought, strict=True)])
    information = along.T @ (sure.information + prior) @ along * np.outer(ranges, ranges)
    values, vectors = np.linalg.eigh(information + 12.0 * np.eye(ranges.size))
    deviations = 1.0 / np.sqrt(np.maximum(values, 12.0))  # the least there is; large ones round it
    steps = along @ (NORMAL * deviations * vectors * ranges[:, np.newaxis])
    untold = (deviations > UNSURE) | ~are_straight(
        problem, x, weights, steps, sure.information, deviations > SURE
    )
    shares = vectors**2 / values
    doubtful = shares[:, untold].sum(axis=1) / shares.sum(axis=1)
    told = 2.0 * NORMAL * sure.deviations <= WIDEST
    part = sure.deviations[sought] * np.sqrt(doubtful)
    told[sought] &= (doubtful < SHARE) | (part < SURE)
    found: NDArray[np.bool_] = told[: len(problem.space.ranges)]
    return found


def following_directions(problem: Problem, information: Matrix, sought: NDArray[np.bool_]) -> Matrix:
    """How all unknowns move with those sought, the others at their best; shape (unknowns, sought)."""
    along = np.eye(sought.size)[:, sought]
    if not sought.all():
        prior = np.diag([one.prior for one in problem.unknowns])
        own = (information + prior)[np.ix_(~sought, ~sought)]
        along[~sought] = -np.linalg.solve(own, information[np.ix_(~sought, sought)])
    return along


def are_straight(
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
        shown = np.stack(
            [shift_signals(shown[:, :, k], delay, one.whole) for k, delay in enumerate(late)], axis=2
        )
        for name, measured in one.segment.measured.items():
            values = shown[:, PLACES[name], :]
            if (one.segment.log, name) in offsets:
                i, scale = offsets[one.segment.log, name]
                values = values + scale * points[:, i]
            size = np.abs(weights[one.segment.log, name] * (measured[:, np.newaxis] - values))
            rho = np.where(size <= KNEE, 0.5 * size**2, KNEE * (size - 0.5 * KNEE))
            total += np.nansum(np.where(np.isnan(values), np.inf, rho), axis=0)
    return total
