"""A monotone table through noisy samples of a valve's characteristic, flat in its dead band."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.maps.bent import rising_values, rough_curve, step_means
from hydroservo.identification.maps.sweeps import FEWEST, Pass
from hydroservo.identification.regression import NORMAL, Regression, long_run_covariance, regression
from hydroservo.identification.segments import noise_of

NEAR = 0.1  # of the largest answer, up to which samples tell where it begins
BEYOND_NULL = 3  # means beyond null, at least, that tell it too
ABOVE_NULL = 0.01  # of the largest answer, from which a mean is beyond null
TRIALS = 200  # commands at which the answer may begin
STRAIGHT = 0.65  # of the answer about null that its line is, at least, where it has a slope at its edge
ROUNDING = 1e-12  # of the squares of the answer, that are left by rounding
POINTS = 14  # of each side before any is added
GRADE = 1.6  # the power by which points are closer about null
NEXT = 0.2  # of a step, that points keep from the edge and from the end
ROUNDS = 6  # in which points are added
BENDS = 1e-3  # of the largest answer, that samples between two points may lie beside their line
APART = 0.25  # of the step between two points, that one added keeps from both
SURE = 3.0  # deviations of a mean, from which it is beyond noise
TRACE = 0.01  # of the largest answer, which is none
FEW_LEVELS = "too few levels about null tell where the answer begins: add some there"
BENT_START = "the curve bends too much about null to tell where it begins"
TINY = 1e-6  # of the widest interval, below which none counts more

Samples = NDArray[np.float64]


class Edge(NamedTuple):
    """Where the answer begins in one direction."""

    command: float  # [V]
    half: float  # half of the 95 % interval [V]; nan where the samples do not end it
    slope: float  # of the answer where it begins, per volt
    why: str = ""  # it cannot be determined; empty where it can


class Points(NamedTuple):
    """Points of one side but its edge, from null outwards: shape (n,) each."""

    command: Samples  # [V]
    answer: Samples
    half: Samples  # half of the 95 % interval


def mirror_passes(sweeps: Sequence[Pass]) -> list[Pass]:
    """The negative side as if it were the positive one."""
    return [one._replace(command=-one.command, answer=-one.answer) for one in sweeps]


def has_answer(sweeps: Sequence[Pass]) -> bool:
    """Whether the answer at the largest commands is beyond noise, and no mere trace of the other side's."""
    _, means, counts = step_means(sweeps, 2 * POINTS)
    unsure = SURE * noise_of(np.concatenate([one.answer for one in sweeps])) / np.sqrt(counts[-1])
    return bool(means[-1] > max(unsure, TRACE * np.abs(means).max()))


def samples_between(sweeps: Sequence[Pass], low: float, high: float) -> list[Pass]:
    """The samples between two commands."""
    on = [(one, (one.command >= low) & (one.command <= high)) for one in sweeps]
    return [Pass(one.rising, *(row[there] for row in one[1:])) for one, there in on if there.any()]


def answer_edge(sweeps: Sequence[Pass]) -> Edge:
    """The command at which the positive answer begins, with all samples below it at 0::

        y = a (u - u_0) + b (u - u_0)^2 above u_0,   a >= 0, b >= 0

    The interval is that of all u_0 whose squares of what is left are near to the least, as likelihood has it.
    Where it reaches the ends of the samples there is none, and the command is the first of these u_0. Where b
    makes much of the answer, as of a curve that leaves null with no slope, it may not hold the truth.

    Source: least squares over u_0, with a and b of each by non-negative least squares.
    """
    at, curve = rough_curve(sweeps)
    near = np.abs(curve) <= NEAR * curve[-1]
    near[np.flatnonzero(curve > ABOVE_NULL * curve[-1])[:BEYOND_NULL]] = True
    low, high = at[near][0], at[near][-1]
    taken = samples_between(sweeps, low, high)
    few, means, counts = step_means(taken, TRIALS)
    trials = np.linspace(low, high, TRIALS, endpoint=False)
    a, b, squares = np.array([fit_edge(few, means, np.sqrt(counts), trial) for trial in trials]).T
    best = int(np.argmin(squares))
    limit = squares[best] + NORMAL**2 * variance_beyond(taken, trials[best], a[best], b[best])
    first, last = np.flatnonzero(squares <= limit + ROUNDING * float(counts @ means**2))[[0, -1]]
    half = max(trials[best] - trials[first], trials[last] - trials[best]) + trials[1] - trials[0]
    slope = float(a[best] or b[best] * (high - trials[best]))
    if first == 0 or last == TRIALS - 1:
        return Edge(float(trials[first]), np.nan, slope, FEW_LEVELS)
    bent = a[first] < STRAIGHT * (a[first] + b[first] * (high - trials[first]))
    return Edge(float(trials[best]), float(half), slope, BENT_START if bent else "")


def variance_beyond(sweeps: Sequence[Pass], edge: float, a: float, b: float) -> float:
    """The variance of what is left above an edge, with what hangs together over time counted as less."""
    above = [(one.command - edge, one.answer) for one in samples_between(sweeps, edge, np.inf)]
    parts = [(y - a * u - b * u**2)[:, np.newaxis] for u, y in above if u.size > 1]
    return float(long_run_covariance(parts)[0, 0]) / sum(map(len, parts)) if parts else np.inf


def fit_edge(u: Samples, y: Samples, weights: Samples, edge: float) -> tuple[float, float, float]:
    """a, b, and the squares of what is left of the means with the answer that begins at a command."""
    from scipy.optimize import nnls

    along = np.maximum(u - edge, 0.0)
    (a, b), left = nnls(weights[:, np.newaxis] * np.stack([along, along**2], axis=1), weights * y)
    return float(a), float(b), float(left**2)


def side_points(sweeps: Sequence[Pass], edge: float) -> Points | None:
    """The points of the positive side, whose line begins with 0 at its edge; None where samples are too few.

    The line through them is that of least squares, and values that fall are pooled. Points stand closer about
    null, and closer still where samples between two lie beside their line beyond noise.
    """
    taken = samples_between(sweeps, edge, np.inf)
    if sum(one.command.size for one in taken) < FEWEST:
        return None
    knots = graded_points(np.concatenate([one.command for one in taken]), edge)
    found = line_points(taken, knots)
    if found is None:
        return None
    for _ in range(ROUNDS):
        closer = np.union1d(knots, new_points(taken, knots, found.values))
        better = line_points(taken, closer) if closer.size > knots.size else None
        if better is None:
            break
        knots, found = closer, better
    half = NORMAL * np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    rising = rising_values(found.values, 1.0 / np.maximum(half, TINY * half.max() or 1.0) ** 2)
    above = rising > 0.0
    return Points(knots[1:][above], rising[above], half[above])


def graded_points(command: Samples, edge: float) -> Samples:
    """The edge, and a command that was met in each of steps that grow from there on, and the largest one."""
    top = float(command.max())
    steps = edge + (top - edge) * np.linspace(0.0, 1.0, POINTS + 1) ** GRADE
    every = np.sort(command)
    parts = np.split(every, np.searchsorted(every, steps[1:-1]))
    met = np.array([part[part.size // 2] for part in parts if part.size >= FEWEST])
    inner = (met - edge > NEXT * (steps[1] - edge)) & (top - met > NEXT * (top - steps[-2]))
    return np.array([edge, *met[inner], top])


def line_points(sweeps: Sequence[Pass], knots: Samples) -> Regression | None:
    """The answers at all points but the first, whose answer is 0, by least squares."""
    return regression([(shares(one.command, knots), one.answer) for one in sweeps])


def shares(command: Samples, knots: Samples) -> Samples:
    """The share that each point but the first has in a line through all, shape (n, points - 1)."""
    return np.stack([np.interp(command, knots, row) for row in np.eye(knots.size)[1:]], axis=1)


def new_points(sweeps: Sequence[Pass], knots: Samples, values: Samples) -> list[float]:
    """A command that was met between each two points beside whose line the samples lie beyond noise."""
    u = np.concatenate([one.command for one in sweeps])
    order = np.argsort(u, kind="stable")
    u = u[order]
    left = np.concatenate([one.answer for one in sweeps])[order] - np.interp(u, knots, [0.0, *values])
    found = []
    for low, high in pairwise(knots.tolist()):
        margin = APART * (high - low)
        inner = slice(*np.searchsorted(u, [low + margin, high - margin]))
        count = inner.stop - inner.start
        if count < FEWEST:
            continue
        beside = left[inner]
        unsure = SURE * float(beside.std(ddof=1)) / np.sqrt(count)
        if abs(float(beside.mean())) > max(BENDS * float(values[-1]), unsure):
            found.append(float(u[inner][count // 2]))
    return found
