"""How far two laws are apart on the same conditions, and how sure that is."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
LEAST = 1e-12  # a chance is never 0


class Difference(NamedTuple):
    """A mean with its interval; infinitely wide where nothing can be said of it.

    Attributes:
        value: its estimate; nan where there is none.
        low, high: the ends of its interval.
        chance: of a mean at least as far from 0 where it is 0; two-sided.
    """

    value: float
    low: float
    high: float
    chance: float


UNKNOWN = Difference(np.nan, -np.inf, np.inf, 1.0)


def difference(a: Numbers, b: Numbers, confidence: float = 0.95) -> Difference:
    """The mean difference of two laws over conditions, by Student's t of their pairs.

    Args:
        a, b: of the same conditions; nan where a run does not count. A condition counts where both do.
        confidence: of the interval.

    Fails: it holds for other conditions, not for other searches: a law whose search stopped too early looks
    worse than it is. With one condition nothing tells the law from luck, and the interval is infinite; it is
    too narrow where few conditions of a long-tailed kind hold the difference.
    """
    return mean(a - b, confidence)


def mean(values: Numbers, confidence: float = 0.95) -> Difference:
    """The mean of some draws, by Student's t; those that are nan do not count."""
    from scipy.special import stdtr, stdtrit

    known = values[~np.isnan(values)]
    if not known.size:
        return UNKNOWN
    middle = float(known.mean())
    if known.size < 2:
        return Difference(middle, -np.inf, np.inf, 1.0)
    error = float(known.std(ddof=1)) / known.size**0.5
    if error == 0.0:
        return Difference(middle, middle, middle, 1.0 if middle == 0.0 else LEAST)
    half = float(stdtrit(known.size - 1, 0.5 + confidence / 2.0)) * error
    chance = 2.0 * float(stdtr(known.size - 1, -abs(middle) / error))
    return Difference(middle, middle - half, middle + half, max(chance, LEAST))


def exponentials(logs: Difference) -> tuple[float, float, float]:
    """A mean of logarithms and the ends of its interval as what they are logarithms of."""
    with np.errstate(over="ignore"):
        value, low, high = np.exp(logs[:3])
    return float(value), float(low), float(high)
