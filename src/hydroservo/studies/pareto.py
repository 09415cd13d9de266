"""Fronts of error and command activity, and the evolution of points that are good in both, NSGA-II."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Numbers = NDArray[np.float64]

STILL = 0.01  # a front that moves less by as many candidates again is still
MOST = float(np.log(2.0))  # by which a point of a front moves, where there was none before
CROSSOVER_INDEX, MUTATION_INDEX = 15.0, 20.0  # the larger, the nearer children are to their parents


def on_front(costs: ArrayLike) -> NDArray[np.bool_]:
    """Whether each row is on Pareto's front: no other is at most as large in all columns, and smaller in one.

    Args:
        costs: of shape (points, what is to be small).
    """
    rows = np.asarray(costs, dtype=np.float64)
    if not rows.size:
        return np.zeros(0, dtype=np.bool_)
    beaten: NDArray[np.bool_] = np.any(dominates(rows), axis=0)
    return ~beaten


def dominates(costs: Numbers) -> NDArray[np.bool_]:
    """Whether each row is at most as large as each other one in all columns, and smaller in one."""
    each = costs[:, np.newaxis]
    return np.logical_and((each <= costs).all(axis=2), (each < costs).any(axis=2))


def front_shift(before: Numbers, now: Numbers) -> float:
    """How far a front moved: by what its points are better, on average, than the front before them.

    Of each point it is the least by which some point of the front before it would have to be better in both.

    Args:
        before, now: points of shape (points, 2): logarithms of error and of activity.

    Source: Zitzler, Thiele, Laumanns, Fonseca, da Fonseca 2003, doi:10.1109/TEVC.2003.810758: the additive
    epsilon indicator, of each point in place of the worst one.
    """
    short = (before - now[:, np.newaxis]).max(axis=2).min(axis=1)
    return float(np.clip(short, 0.0, MOST).mean())


def evenly_spaced(points: Numbers, count: int) -> NDArray[np.int64]:
    """Members of a front at activities that are evenly spaced: of each, the one with the least error.

    Args:
        points: of shape (points, 2): logarithms of error and of activity.
        count: the most there are to be.
    """
    members = np.flatnonzero(on_front(points))
    own = points[members]
    at = np.linspace(own[:, 1].min(), own[:, 1].max(), count)
    calm = own[:, 1] <= at[:, np.newaxis] + 1e-12
    best = np.where(calm, own[:, 0], np.inf).argmin(axis=1)
    found: NDArray[np.int64] = members[np.unique(best)]
    return found


def offspring(units: Numbers, costs: Numbers, random: np.random.Generator) -> Numbers:
    """As many new points of the unit cube as there are, near those that are better or more alone.

    Parents are drawn in tournaments of two; children come from simulated binary crossover and polynomial
    mutation, and are reflected into the cube.

    Args:
        units: the points, shape (points, dimensions).
        costs: their two costs, shape (points, 2).
        random: the source of all draws.

    Source: Deb, Pratap, Agarwal, Meyarivan 2002, doi:10.1109/4235.996017; Deb and Agrawal 1995, Simulated
    binary crossover for continuous search space, Complex Systems 9, 115-148.
    """
    count = len(units)
    place = np.empty(count, dtype=np.int64)
    place[fittest(costs, count)] = np.arange(count)
    pairs = random.integers(count, size=(2, count))
    parents = units[np.where(place[pairs[0]] < place[pairs[1]], pairs[0], pairs[1])]
    return reflect(mutate(crossover(parents, random), random))


def crossover(parents: Numbers, random: np.random.Generator) -> Numbers:
    """Children of neighbouring parents, each number crossed in half of the cases."""
    one, other = parents, np.roll(parents, 1, axis=0)
    u = random.random(parents.shape)
    power = 1.0 / (CROSSOVER_INDEX + 1.0)
    spread = np.where(u <= 0.5, (2.0 * u) ** power, (0.5 / (1.0 - u)) ** power)
    child = 0.5 * ((1.0 + spread) * one + (1.0 - spread) * other)
    return np.where(random.random(parents.shape) < 0.5, child, one)


def mutate(children: Numbers, random: np.random.Generator) -> Numbers:
    """Children of which one number each, on average, has moved."""
    u = random.random(children.shape)
    power = 1.0 / (MUTATION_INDEX + 1.0)
    step = np.where(u < 0.5, (2.0 * u) ** power - 1.0, 1.0 - (2.0 * (1.0 - u)) ** power)
    return children + np.where(random.random(children.shape) < 1.0 / children.shape[1], step, 0.0)


def reflect(points: Numbers) -> Numbers:
    """Points inside the unit cube, folded at its faces."""
    return 1.0 - np.abs(1.0 - np.mod(points, 2.0))


def fittest(costs: Numbers, count: int) -> NDArray[np.int64]:
    """Which points are the best: by nondominated rank, then by crowding distance, the largest first.

    Args:
        costs: of shape (points, 2), finite.
        count: how many.
    """
    ranks = nondominated_ranks(costs)
    crowding = np.zeros(len(costs))
    for rank in range(int(ranks.max()) + 1):
        members = np.flatnonzero(ranks == rank)
        crowding[members] = crowding_distances(costs[members])
    return np.lexsort((-crowding, ranks))[:count]


def nondominated_ranks(costs: Numbers) -> NDArray[np.int64]:
    """The rank of each point: 0 on the front of all, 1 on that of those that are left without it, and on."""
    beats = dominates(costs)
    ranks = np.full(len(costs), -1)
    left, rank = np.ones(len(costs), dtype=np.bool_), 0
    while left.any():
        best = left & ~beats[left, :].any(axis=0)
        ranks[best] = rank
        left, rank = left & ~best, rank + 1
    return ranks


def crowding_distances(costs: Numbers) -> Numbers:
    """How far the neighbours of each point of a front are from each other; infinite at its ends."""
    found = np.zeros(len(costs))
    for own in costs.T:
        order = np.argsort(own, kind="stable")
        span = own[order[-1]] - own[order[0]]
        found[order[[0, -1]]] = np.inf
        if span > 0.0:
            found[order[1:-1]] += (own[order[2:]] - own[order[:-2]]) / span
    return found
