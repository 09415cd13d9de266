"""Ranges of numbers as a unit cube, and the search of the point in it at which a function is smallest."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]

CANDIDATES = 64  # of a generation: whole groups of lanes
DIGITS = 5  # of a rounded point; a rig's gains have no more


class Space(NamedTuple):
    """Ranges as a unit cube."""

    ranges: Mapping[str, tuple[float, float]]

    def values(self, units: Numbers) -> dict[str, Numbers]:
        """Parameters by path for points of shape (candidates, paths)."""
        found = {}
        for (path, (low, high)), unit in zip(self.ranges.items(), units.T, strict=True):
            between = low * (high / low) ** unit if low * high > 0.0 else low + (high - low) * unit
            found[path] = np.clip(between, low, high)
        return found

    def units(self, values: Numbers) -> Numbers:
        """The points of the cube that have some parameters, both of shape (candidates, paths)."""
        found = np.empty_like(values)
        for k, (low, high) in enumerate(self.ranges.values()):
            own = values[:, k]
            found[:, k] = (
                np.log(own / low) / np.log(high / low) if low * high > 0.0 else (own - low) / (high - low)
            )
        return np.clip(found, 0.0, 1.0)

    def rounded(self, unit: Numbers) -> dict[str, float]:
        """Parameters by path for one point of shape (paths,), with few digits."""
        found = {}
        for path, (value,) in self.values(unit[np.newaxis]).items():
            low, high = self.ranges[path]
            found[path] = min(max(float(f"{value:.{DIGITS}g}"), low), high)
        return found


def latin_hypercube(count: int, dimensions: int, seed: int) -> Numbers:
    """Points spread over the unit cube, shape (count, dimensions): those of scipy's LatinHypercube."""
    (rng,) = np.random.default_rng(seed).spawn(1)
    inside = rng.uniform(size=(count, dimensions))
    cells = rng.permuted(np.tile(np.arange(1, count + 1), (dimensions, 1)), axis=1)
    return np.asarray((cells.T - inside) / count)


def minimum(cost: Callable[[Numbers], Any], dimensions: int, generations: int, seed: int) -> Numbers:
    """The point of the unit cube at which a function of points of shape (dimensions, points) is smallest."""
    from scipy.optimize import differential_evolution

    found = differential_evolution(
        cost,
        [(0.0, 1.0)] * dimensions,
        init=latin_hypercube(CANDIDATES, dimensions, seed),
        maxiter=generations - 1,
        tol=0.0,
        atol=-1.0,  # never ends early: every law gets as many candidates
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng([seed, 1]),
    )
    return np.asarray(found.x)
