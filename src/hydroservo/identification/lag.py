"""How much later a machine was seen to answer than it would have."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]


def lag(
    measured: Mapping[str, Samples],
    shown: Mapping[str, Samples],
    weights: Mapping[str, float],
    least: int,
    most: int,
) -> int:
    """The whole number of samples by which measured signals come after simulated ones: what leaves least.

    Args:
        measured: by name, shape (n,); nan where nothing was measured.
        shown: those signals, and maybe others, as simulated.
        weights: of each measured signal.
        least: the smallest lag that is tried; less than 0 for measured signals that come first.
        most: the largest one.
    """
    every = [weights[name] ** 2 * variances(one, shown[name], least, most) for name, one in measured.items()]
    total = np.sum(every, axis=0)
    return least + int(np.argmin(np.where(np.isfinite(total), total, np.inf)))


def left(
    measured: Mapping[str, Samples], shown: Mapping[str, Samples], weights: Mapping[str, float], shift: int
) -> float:
    """The weighted squares of the differences at a lag, a signal's mean difference left out; inf if lost.

    A simulated signal is held before its first and after its last sample, as the search has it.
    """
    total = 0.0
    for name, values in measured.items():
        places = np.clip(np.arange(values.size) - shift, 0, values.size - 1)
        apart = (values - shown[name][places])[np.isfinite(values)]
        total += weights[name] ** 2 * float(np.var(apart))
    return total if np.isfinite(total) else np.inf


def variances(measured: Samples, shown: Samples, least: int, most: int) -> Samples:
    """The variance of a difference at each lag, by Fourier transforms of the correlations in it."""
    before, after = max(most, 0), max(-least, 0)
    there = np.isfinite(measured).astype(np.float64)
    own = np.where(there > 0.0, measured, 0.0) - there * np.nanmean(measured)
    held = np.pad(shown - shown.mean(), (before, after), mode="edge")
    spectra = np.conj(np.fft.rfft([there, own], held.size))
    first, second = np.fft.rfft([held, held**2])
    products = [first * spectra[0], second * spectra[0], first * spectra[1]]
    sums, squares, products_of = np.fft.irfft(products, held.size)[:, before - np.arange(least, most + 1)]
    count = there.sum()
    return np.asarray(((own**2).sum() - 2.0 * products_of + squares) / count - (sums / count) ** 2)
