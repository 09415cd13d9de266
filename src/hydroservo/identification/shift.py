"""A sampled signal somewhat later."""

import numpy as np
from numpy.typing import NDArray

STEP = 0.05  # of a sample, for the difference by the shift

Samples = NDArray[np.float64]


def shifted(values: Samples, delay: float) -> Samples:
    """Signals as they were so many samples before, by a cubic through four samples.

    Before the first and after the last sample they are held.

    Args:
        values: shape (n, ...), samples first.
        delay: in samples; less than 0 for later ones.

    Source: Lagrange's polynomial.
    Fails between samples over which a signal jumps.
    """
    whole = int(np.floor(delay))
    f = delay - whole
    places = np.arange(len(values)) - whole
    before = [values[np.clip(places - k, 0, len(values) - 1)] for k in (-1, 0, 1, 2)]
    weights = (
        f * (f - 1.0) * (2.0 - f) / 6.0,
        (1.0 + f) * (1.0 - f) * (2.0 - f) / 2.0,
        (1.0 + f) * f * (2.0 - f) / 2.0,
        (1.0 + f) * f * (f - 1.0) / 6.0,
    )
    found: Samples = np.sum([weight * one for weight, one in zip(weights, before, strict=True)], axis=0)
    return found


def slope_of_shift(values: Samples, delay: float) -> Samples:
    """How shifted signals change with the delay, per sample."""
    ends = shifted(values, delay + STEP), shifted(values, delay - STEP)
    return (ends[0] - ends[1]) / (2.0 * STEP)
