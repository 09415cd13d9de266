"""NSGA-II: known fronts are found, inside the cube, the same each time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.studies.fronts import (
    crowding_distances,
    fittest,
    nondominated_ranks,
    offspring,
    on_front,
    reflect,
)


def evolved(costs_of, dimensions, generations=40, size=64, seed=0):
    random = np.random.default_rng(seed)
    units = random.random((size, dimensions))
    costs = costs_of(units)
    for _ in range(generations):
        children = offspring(units, costs, random)
        units, costs = np.concatenate([units, children]), np.concatenate([costs, costs_of(children)])
        kept = fittest(costs, size)
        units, costs = units[kept], costs[kept]
    return units, costs


def schaffer(units):
    """The front is where the first number lies between 0.25 and 0.75 and the others are 0.5."""
    rest = ((units[:, 1:] - 0.5) ** 2).sum(axis=1)
    return np.stack([(units[:, 0] - 0.25) ** 2 + rest, (units[:, 0] - 0.75) ** 2 + rest], axis=1)


@pytest.mark.parametrize("dimensions", [1, 3, 8])
def test_a_known_front_is_found_from_end_to_end(dimensions):
    units, costs = evolved(schaffer, dimensions, generations=80)
    assert on_front(costs).mean() > 0.9
    assert np.abs(units[:, 1:] - 0.5).max(initial=0.0) < 0.1
    first = np.sort(units[:, 0])
    assert (first[0], first[-1]) == pytest.approx((0.25, 0.75), abs=0.03)
    assert np.diff(first).max() < 0.06  # spread evenly, as crowding wants it


def test_zdt1_comes_near_its_front():
    """Source: Zitzler, Deb, Thiele 2000, doi:10.1162/106365600568202: the best has f2 = 1 - sqrt(f1)."""

    def zdt1(units):
        g = 1.0 + 9.0 * units[:, 1:].mean(axis=1)
        return np.stack([units[:, 0], g * (1.0 - np.sqrt(units[:, 0] / g))], axis=1)

    _, costs = evolved(zdt1, 10, generations=150)
    above = costs[:, 1] - (1.0 - np.sqrt(costs[:, 0]))
    assert above.min() >= 0.0
    assert np.median(above) < 0.06


def test_the_same_seed_gives_the_same_points():
    first, again, other = (evolved(schaffer, 3, 5, seed=seed)[0] for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=1, max_size=20))
def test_ranks_peel_fronts(costs):
    costs = np.array(costs, dtype=float)
    ranks = nondominated_ranks(costs)
    for rank in range(ranks.max() + 1):
        left = ranks >= rank
        assert np.array_equal(ranks[left] == rank, on_front(costs[left]))


def test_ends_are_kept_and_crowds_thinned():
    line = np.array([[0.0, 9.0], [1.0, 8.0], [1.1, 7.9], [5.0, 4.0], [9.0, 0.0]])
    assert np.isinf(crowding_distances(line)[[0, 4]]).all()
    assert set(fittest(line, 4)) == {0, 1, 3, 4} or set(fittest(line, 4)) == {0, 2, 3, 4}
    assert fittest(np.vstack([line, [[9.0, 9.0]]]), 6)[-1] == 5


def test_points_are_folded_into_the_cube():
    assert reflect(np.array([-0.25, 0.5, 1.25, 1.0])) == pytest.approx([0.25, 0.5, 0.75, 1.0])
