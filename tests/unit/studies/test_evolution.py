"""CMA-ES: it finds minima that are known, alike each time, and outlives its own convergence."""

from collections.abc import Callable

import numpy as np
import pytest

from hydroservo.studies.evolution import evolved

MIDDLE = np.array([[0.3], [0.7], [0.45]])


def best(
    cost: Callable[[np.ndarray], np.ndarray], dimensions: int, generations: int, seed: int = 0
) -> np.ndarray:
    """All points that were asked for, the best first; each generation is one array of them."""
    asked = []

    def heard(points: np.ndarray) -> np.ndarray:
        asked.append(points.T)
        return cost(points)

    evolved(heard, dimensions, generations, seed)
    assert len(asked) == generations
    points = np.concatenate(asked)
    assert points.shape == (64 * generations, dimensions)
    assert points.min() >= 0.0
    assert points.max() <= 1.0
    return points[np.argsort(cost(points.T), kind="stable")]


def valley(points: np.ndarray) -> np.ndarray:
    """A quadratic a thousand times as steep across its diagonals as along them, smallest at MIDDLE."""
    x = points - MIDDLE
    return x.sum(axis=0) ** 2 + 1e3 * (x[0] - x[1]) ** 2 + 1e3 * (x[1] - x[2]) ** 2


def test_it_finds_the_bottom_of_a_narrow_valley() -> None:
    np.testing.assert_allclose(best(valley, 3, 30)[0], MIDDLE[:, 0], atol=1e-3)


def test_it_finds_a_corner() -> None:
    np.testing.assert_allclose(best(lambda x: x[0] - x[1], 2, 30)[0], [0.0, 1.0], atol=1e-3)


def test_the_same_seed_asks_for_the_same_points_and_another_for_others() -> None:
    first, again, other = (best(valley, 3, 5, seed) for seed in (3, 3, 4))
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()


@pytest.mark.parametrize(
    "cost",
    [lambda x: (x[0] - 0.3) ** 2, lambda x: 0.0 * x[0], lambda x: np.where(x[0] < 0.5, np.inf, x[0])],
    ids=["one number", "flat", "half of it impossible"],
)
def test_a_search_that_has_converged_goes_on_elsewhere(cost: Callable[[np.ndarray], np.ndarray]) -> None:
    """With one number it converges after some 15 generations; without a new start its step becomes 0 / 0."""
    points = best(cost, 1, 200)
    assert np.isfinite(points).all()
    assert np.ptp(points) > 0.4


def test_nothing_possible_is_no_error() -> None:
    assert len(best(lambda x: np.full(x.shape[1], np.inf), 2, 40)) == 64 * 40
