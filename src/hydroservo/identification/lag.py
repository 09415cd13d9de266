"""How much later a machine was seen to answer than it would have."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["lag", "left"]

EARLY = 1  # samples by which it may have answered earlier

Samples = NDArray[np.float64]


def lag(
    measured: Mapping[str, Samples], shown: Mapping[str, Samples], weights: Mapping[str, float], most: int
) -> int:
    """The whole number of samples by which measured signals come after simulated ones: what leaves least.

    Args:
        measured: by name, shape (n,); nan where nothing was measured.
        shown: those signals, and maybe others, as simulated.
        weights: of each measured signal.
        most: the largest lag that is tried.
    """
    return min(range(-EARLY, most + 1), key=lambda shift: left(measured, shown, weights, shift))


def left(
    measured: Mapping[str, Samples], shown: Mapping[str, Samples], weights: Mapping[str, float], shift: int
) -> float:
    """The weighted squares of the differences at a lag, a signal's mean difference left out; inf if lost."""
    every = [weights[name] ** 2 * variance(one, shown[name], shift) for name, one in measured.items()]
    total = float(np.sum(every))
    return total if np.isfinite(total) else np.inf


def variance(measured: Samples, shown: Samples, shift: int) -> float:
    """The variance of a difference, one of its signals shifted."""
    size = measured.size - abs(shift)
    apart = measured[max(shift, 0) :][:size] - shown[max(-shift, 0) :][:size]
    there = np.isfinite(measured[max(shift, 0) :][:size])
    return float(np.var(apart[there]))
