"""Lost runs: their share with its interval, and whether one law loses more of them than another."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.paired import Difference, difference, spread

__all__ = ["Share", "fewer_lost", "lost_share"]

Flags = NDArray[np.bool_]


class Share(NamedTuple):
    """A share with its interval.

    Attributes:
        lost: how many.
        value: their share.
        low, high: the ends of its interval.
    """

    lost: int
    value: float
    low: float
    high: float


def lost_share(lost: Flags, confidence: float = 0.95) -> Share:
    """The share of lost runs with Wilson's interval.

    Runs of one search, or on one condition, are lost together: they count as p (1 - p) / v independent ones,
    of which a share p would have the variance v that is seen. Where none or all are lost each condition
    counts once.

    Args:
        lost: of shape (searches, conditions).
        confidence: of the interval.

    Source: Wilson 1927, doi:10.2307/2276774; the number of independent runs as Korn and Graubard 1998 take
    it.
    """
    share = float(lost.mean())
    runs = float(lost.shape[1])
    if 0.0 < share < 1.0 and min(lost.shape) > 1:
        variance = spread(lost.astype(np.float64))
        runs = min(max(share * (1.0 - share) / variance, 1.0), float(lost.size))
    low, high = wilson(share, runs, confidence)
    return Share(int(lost.sum()), share, low, high)


def wilson(share: float, runs: float, confidence: float) -> tuple[float, float]:
    """Wilson's interval of a share of so many independent runs."""
    from scipy.stats import norm

    z2 = float(norm.ppf(0.5 + confidence / 2.0)) ** 2
    middle = (share + z2 / (2.0 * runs)) / (1.0 + z2 / runs)
    half = (z2 * (share * (1.0 - share) / runs + z2 / (4.0 * runs**2))) ** 0.5 / (1.0 + z2 / runs)
    low = 0.0 if share == 0.0 else middle - half
    return low, 1.0 if share == 1.0 else middle + half


def fewer_lost(a: Flags, b: Flags, confidence: float = 0.95) -> Difference:
    """How much greater a's share of lost runs is than b's.

    Its chance is the larger of two: that of :func:`~hydroservo.studies.paired.difference`, which knows that
    one bad search loses many runs, and that of the exact sign test over the conditions in which one law lost
    more than the other, which a handful of lost runs does not impress.

    Args:
        a, b: of shape (searches, conditions), the conditions the same.
        confidence: of the interval.
    """
    from scipy.stats import binomtest

    found = difference(a.astype(np.float64), b.astype(np.float64), confidence)
    sign = np.sign(a.mean(axis=0) - b.mean(axis=0))
    unlike = int((sign != 0).sum())
    chance = binomtest(int((sign > 0).sum()), unlike).pvalue if unlike else 1.0
    return found._replace(chance=max(found.chance, float(chance)))
