"""The frequency response of evenly sampled signals, by averaged windows."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError

WINDOWS = 16  # that are averaged, at least: without a relation the coherence is 1/16 then
SHORTEST = 64  # samples of a window
FIRST = 2  # of its lines that is told: the ones before it hold what a signal drifts by
LAST = 0.9  # of Nyquist's frequency
EXCITED = 1e-6  # of the largest power density of what drives, below which nothing does

Samples = NDArray[np.float64]


class Estimate(NamedTuple):
    """A response over frequency.

    Attributes:
        frequency: [Hz], where something excites.
        response: output by input, in their units.
        coherence: from 0 to 1.
    """

    frequency: Samples
    response: NDArray[np.complex128]
    coherence: Samples


def welch(parts: Sequence[tuple[Samples, Samples]], period: float, name: str) -> Estimate:
    """The response of an output to an input, and their coherence, of at least sixteen windows.

    With the spectra of Hann windows that overlap by half, a straight line taken out of each::

        G = S_yu/S_uu,   gamma^2 = |S_yu|^2/(S_uu S_yy)

    The variance of G is near |G|^2 (1 - gamma^2)/(2 n gamma^2) for n windows.

    Args:
        parts: pairs of input and output, each of shape (n,); windows lie within one of them.
        period: of the samples [s].
        name: of the log, for what is said.

    Source: Welch, IEEE Trans. Audio and Electroacoustics 15(2), 1967; Bendat, Piersol, Random Data, 2010,
    sec. 6.1 and 9.2 (the variance).
    Fails at resonances narrower than two lines of a window, which look flatter than they are; and where the
    output comes later than a tenth of a window, by that share.
    """
    size = window_for([one.size for one, _ in parts], name)
    long = [part for part in parts if part[0].size >= size]
    u, y = (np.concatenate([spectra(one, size) for one in signal]) for signal in zip(*long, strict=True))
    driving, moved = np.mean(np.abs(u) ** 2, axis=0), np.mean(np.abs(y) ** 2, axis=0)
    cross = np.mean(np.conj(u) * y, axis=0)
    frequency = np.fft.rfftfreq(size, period)
    told = (driving > EXCITED * driving.max()) & (frequency <= LAST * frequency[-1]) & (moved > 0.0)
    told[:FIRST] = False
    if not told.any():
        raise ScenarioError(name, "", "nothing excites it, or what is controlled does not move")
    coherence = np.abs(cross[told]) ** 2 / (driving[told] * moved[told])
    return Estimate(frequency[told], cross[told] / driving[told], coherence)


def spectra(signal: Samples, size: int) -> NDArray[np.complex128]:
    """The spectra of a signal's windows, a row each: a straight line taken out, then under Hann's bell."""
    windows = np.lib.stride_tricks.sliding_window_view(signal, size)[:: size // 2]
    time = np.arange(size) - (size - 1) / 2.0
    line = windows.mean(axis=1, keepdims=True) + np.outer(windows @ time, time / (time @ time))
    return np.fft.rfft((windows - line) * np.sin(np.pi * np.arange(size) / size) ** 2)


def window_for(lengths: Sequence[int], name: str) -> int:
    """The longest even number of samples of which sixteen windows lie within the parts."""
    total = sum(lengths)
    for size in range(2 * total // (WINDOWS + 1) // 2 * 2, SHORTEST - 1, -2):
        if sum(windows_in(one, size) for one in lengths) >= WINDOWS:
            return size
    needed = SHORTEST * (WINDOWS + 1) // 2
    problem = f"has {total} samples without a gap, too few for a frequency response; {needed} are needed"
    raise ScenarioError(name, "", problem)


def windows_in(length: int, size: int) -> int:
    """How many windows of a size, each half over the next, lie in so many samples."""
    return max((length - size // 2) // (size - size // 2), 0)
