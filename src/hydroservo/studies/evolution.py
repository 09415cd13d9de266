"""The evolution of points that are good in two ways at once, NSGA-II."""

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.pareto import dominates

Numbers = NDArray[np.float64]

CROSSOVER_INDEX, MUTATION_INDEX = 15.0, 20.0  # the larger, the nearer children are to their parents


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
