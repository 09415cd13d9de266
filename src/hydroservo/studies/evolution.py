"""The evolution strategy with adapted covariance, CMA-ES."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.runs.space import CANDIDATES

__all__ = ["evolved"]

Numbers = NDArray[np.float64]

WORST = 1e300  # stands for infinite costs, whose differences are no numbers
STEP = 0.3  # standard deviation at first, of the cube's sides


def evolved(cost: Callable[[Numbers], Any], dimensions: int, generations: int, seed: int) -> None:
    """Search the unit cube by CMA-ES, from its middle; once it has converged, again from a point drawn there.

    Args:
        cost: of points of shape (dimensions, points); it keeps the best.
        dimensions: of the cube.
        generations: how many, of 64 points each, whatever converges before.
        seed: of the search.

    Source: Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772.
    Fails to promise the best there is: another seed may find a better one.
    """
    starts = np.random.default_rng([seed, 1])
    search = started(np.full(dimensions, 0.5), seed)
    for _ in range(generations):
        if search.should_stop():
            search = started(starts.random(dimensions), int(starts.integers(2**31)))
        points = [search.ask() for _ in range(CANDIDATES)]
        found = np.minimum(cost(np.array(points).T), WORST)
        search.tell([(point, float(one)) for point, one in zip(points, found, strict=True)])


def started(middle: Numbers, seed: int) -> Any:
    """A search from a point of the unit cube."""
    from cmaes import CMA

    bounds = np.tile([0.0, 1.0], (middle.size, 1))
    return CMA(middle, STEP, bounds=bounds, population_size=CANDIDATES, seed=seed)
