"""The evolution of points that are good in two ways at once, NSGA-II."""

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]

CROSSING, MUTATION = 15.0, 20.0  # distribution indices: the larger, the nearer children are to their parents


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
    return reflected(mutated(crossed(parents, random), random))


def crossed(parents: Numbers, random: np.random.Generator) -> Numbers:
    """Children of neighbouring parents, each number crossed in half of the cases."""
    one, other = parents, np.roll(parents, 1, axis=0)
    u = random.random(parents.shape)
    power = 1.0 / (CROSSING + 1.0)
    spread = np.where(u <= 0.5, (2.0 * u) ** power, (0.5 / (1.0 - u)) ** power)
    child = 0.5 * ((1.0 + spread) * one + (1.0 - spread) * other)
    return np.where(random.random(parents.shape) < 0.5, child, one)


def mutated(children: Numbers, random: np.random.Generator) -> Numbers:
    """Children of which one number each, on average, has moved."""
    u = random.random(children.shape)
    power = 1.0 / (MUTATION + 1.0)
    step = np.where(u < 0.5, (2.0 * u) ** power - 1.0, 1.0 - (2.0 * (1.0 - u)) ** power)
    return children + np.where(random.random(children.shape) < 1.0 / children.shape[1], step, 0.0)


def reflected(points: Numbers) -> Numbers:
    """Points inside the unit cube, folded at its faces."""
    return 1.0 - np.abs(1.0 - np.mod(points, 2.0))


def fittest(costs: Numbers, count: int) -> NDArray[np.int64]:
    """Which points are the best, in order: by rank, and among equals those that are most alone.

    Args:
        costs: of shape (points, 2), finite.
        count: how many.
    """
    ranks = ranked(costs)
    crowds = np.zeros(len(costs))
    for rank in range(int(ranks.max()) + 1):
        members = np.flatnonzero(ranks == rank)
        crowds[members] = gaps(costs[members])
    return np.lexsort((-crowds, ranks))[:count]


def ranked(costs: Numbers) -> NDArray[np.int64]:
    """The rank of each point: 0 on the front of all, 1 on that of those that are left without it, and on."""
    each = costs[:, np.newaxis]
    beats = np.logical_and((each <= costs).all(axis=2), (each < costs).any(axis=2))
    ranks = np.full(len(costs), -1)
    left, rank = np.ones(len(costs), dtype=np.bool_), 0
    while left.any():
        best = left & ~beats[left, :].any(axis=0)
        ranks[best] = rank
        left, rank = left & ~best, rank + 1
    return ranks


def gaps(costs: Numbers) -> Numbers:
    """How far the neighbours of each point of a front are from each other; infinite at its ends."""
    found = np.zeros(len(costs))
    for own in costs.T:
        order = np.argsort(own, kind="stable")
        span = own[order[-1]] - own[order[0]]
        found[order[[0, -1]]] = np.inf
        if span > 0.0:
            found[order[1:-1]] += (own[order[2:]] - own[order[:-2]]) / span
    return found
