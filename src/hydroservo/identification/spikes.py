"""Samples that a sensor, a cable or a converter made up."""

import numpy as np
from numpy.typing import NDArray

SIGMAS = 8.0  # of the noise that a spike stands out by
SHARE = 0.02  # and of the signal's range
RETURNED = 0.5  # of its height that the signal may have moved on from before to after it
TO_DEVIATION = 1.4826  # from the median of absolute deviations, for normal noise
RANGE = (1.0, 99.0)  # per cent of the samples, between which a signal's range is taken
FEWEST = 8  # samples, of fewer of which none stands out
GRID = 1e-3  # of a step of resolution, by which values may lie beside it

Samples = NDArray[np.float64]


def spikes_in(values: Samples) -> NDArray[np.bool_]:
    """The samples that stand out alone, or two in a row: a jump away, and back.

    A sample is one if it lies farther from the mean of the samples around it (one and three beside) than
    eight deviations of that difference over the whole signal and than 2 % of the signal's range, while the
    signal itself moves by less than half of that from before to after it.

    Args:
        values: shape (n,); nan where a sample is missing, which is no spike.

    Source: the difference to a local mean, with a median as measure, as in Hampel's identifier: Pearson,
    IEEE Trans. Control Systems Technology 10, 2002, doi:10.1109/87.974338.
    Fails to see three in a row, and to know a real pulse of one sample from a spike.
    """
    found = np.zeros(values.size, dtype=bool)
    there = np.isfinite(values)
    found[there] = alone(values[there])
    return found


def alone(values: Samples) -> NDArray[np.bool_]:
    """As :func:`spikes_in`, of samples all of which are there."""
    found = np.zeros(values.size, dtype=bool)
    if values.size < FEWEST:
        return found
    span = float(np.diff(np.percentile(values, RANGE)).item())
    for before, after in ((1, 1), (1, 2), (2, 1)):
        middle = values[before:-after]
        left, right = values[: -before - after], values[before + after :]
        apart = middle - 0.5 * (left + right)
        deviation = TO_DEVIATION * np.median(np.abs(apart - np.median(apart)))
        out = np.abs(apart) > max(SIGMAS * deviation, SHARE * span)
        found[before:-after] |= out & (np.abs(right - left) < RETURNED * np.abs(apart))
    return found


def noise_of(values: Samples) -> float:
    """The standard deviation of white noise on a smooth signal, in its unit.

    It is taken from third differences, which a smooth signal leaves small, and is at least that of the
    signal's own resolution.

    Args:
        values: shape (n,); nan where a sample is missing.
    """
    differences = np.diff(values[np.isfinite(values)], n=3)
    deviation = TO_DEVIATION * float(np.median(np.abs(differences))) / np.sqrt(20.0)
    return float(max(deviation, resolution_of(values) / np.sqrt(12.0)))


def resolution_of(values: Samples) -> float:
    """The step in which a signal is quantised, in its unit; 0 if it is not."""
    levels = np.unique(values[np.isfinite(values)])
    if levels.size < 3 or levels.size > values.size // 2:
        return 0.0
    steps = np.diff(levels)
    step = float(steps[steps > GRID * steps.max()].min())
    return step if np.abs(steps / step - np.round(steps / step)).max() < GRID * levels.size else 0.0
