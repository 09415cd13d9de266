"""Inputs that no sensor should give, mixed with ones that it does."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["beyond", "fuzzed"]

SPECIAL = (
    np.nan,
    np.inf,
    -np.inf,
    1e308,
    -1e308,
    1e30,
    -1e30,
    5e-324,
    -5e-324,
    2.2e-308,
    1e-40,
    0.0,
    -0.0,
)


def fuzzed(normal: NDArray, seed: int, share: float = 0.05) -> NDArray:
    """Rows of inputs, this share of their numbers replaced; every other tenth of the rows is left as it is.

    What comes in those says whether, and when, a law recovers.
    """
    random = np.random.default_rng(seed)
    left = np.arange(len(normal)) // max(1, len(normal) // 10) % 2 == 1
    replaced = (random.random(normal.shape) < share) & ~left[:, np.newaxis]
    return np.where(replaced, random.choice(SPECIAL, normal.shape), normal)


def beyond(commands: NDArray, limit: float) -> NDArray:
    """Which commands are outside of +-limit, infinities among them; NaN is not."""
    return np.abs(commands) > limit
