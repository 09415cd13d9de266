"""Lost runs: their share with its interval, and whether one law loses more of them than another."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.paired import Difference, difference

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

    Args:
        lost: of each condition.
        confidence: of the interval.

    Source: Wilson 1927, doi:10.2307/2276774.
    """
    from scipy.stats import binomtest

    count = int(lost.sum())
    low, high = binomtest(count, lost.size).proportion_ci(confidence, method="wilson")
    return Share(count, count / lost.size, float(low), float(high))


def fewer_lost(a: Flags, b: Flags, confidence: float = 0.95) -> Difference:
    """How much greater a's share of lost runs is than b's.

    Its chance is the larger of two: that of Student's t, and that of the exact sign test over the conditions
    in which one law lost its run and the other did not, which a handful of lost runs does not impress.

    Args:
        a, b: of the same conditions.
        confidence: of the interval.
    """
    from scipy.stats import binomtest

    found = difference(a.astype(np.float64), b.astype(np.float64), confidence)
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    chance = binomtest(only_a, only_a + only_b).pvalue if only_a + only_b else 1.0
    return found._replace(chance=max(found.chance, float(chance)))
