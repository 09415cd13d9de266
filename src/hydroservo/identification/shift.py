"""A sampled signal somewhat later."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

STEP = 0.05  # of a sample, for the difference by the shift

Samples = NDArray[np.float64]


def shifted(values: Samples, delay: float, whole: int | None = None) -> Samples:
    """Signals as they were so many samples before, by a cubic through four samples.

    Before the first and after the last sample they are held.

    Args:
        values: shape (n, ...), samples first.
        delay: in samples; less than 0 for later ones.
        whole: number of samples, from one less to two more of which the cubic goes; by default those that
            end within the delay.

    Source: Lagrange's polynomial.
    Fails between samples over which a signal jumps.
    """
    if whole is None:
        whole = int(np.floor(delay))
    places = np.arange(len(values)) - whole
    return cubic([values[np.clip(places - k, 0, len(values) - 1)] for k in (-1, 0, 1, 2)], delay - whole)


def slope_of_shift(values: Samples, delay: float, whole: int | None = None) -> Samples:
    """How shifted signals change with the delay, per sample."""
    ends = shifted(values, delay + STEP, whole), shifted(values, delay - STEP, whole)
    return (ends[0] - ends[1]) / (2.0 * STEP)


def cubic(last: Sequence[Samples], f: Samples | float) -> Samples:
    """A signal f samples before the last but one of four, of which the last comes first."""
    weights = (
        f * (f - 1.0) * (2.0 - f) / 6.0,
        (1.0 + f) * (1.0 - f) * (2.0 - f) / 2.0,
        (1.0 + f) * f * (2.0 - f) / 2.0,
        (1.0 + f) * f * (f - 1.0) / 6.0,
    )
    found: Samples = np.sum([weight * one for weight, one in zip(weights, last, strict=True)], axis=0)
    return found
