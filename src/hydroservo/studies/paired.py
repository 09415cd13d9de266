"""How far two laws are apart on the same conditions, and how sure that is."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNKNOWN", "Difference", "difference", "spread"]

Numbers = NDArray[np.float64]
LEAST = 1e-12  # a chance is never 0


class Difference(NamedTuple):
    """A difference of means with its interval; infinitely wide where nothing can be said of it.

    Attributes:
        value: its estimate; nan where there is none.
        low, high: the ends of its interval.
        chance: of a difference at least as large where there is none; two-sided.
    """

    value: float
    low: float
    high: float
    chance: float


UNKNOWN = Difference(np.nan, -np.inf, np.inf, 1.0)


def difference(a: Numbers, b: Numbers, confidence: float = 0.95) -> Difference:
    r"""The difference of two means over searches and conditions, which are both random draws.

    With d(c) the difference of the laws' means over their searches in condition c, the estimate is the mean
    of d(c). Its variance has a part of the n conditions and one of the S searches of each law, whose means
    over conditions are a(s) and b(s); s^2 is the variance of a sample:

    .. math:: v_c = s^2(d) / n, \quad v_a = s^2(a) / S_a, \quad v_b = s^2(b) / S_b.

    All hold what searches and conditions do together, v_i: the whole is v_c + v_a + v_b - v_i, and no less
    than the part of the conditions or that of the searches. The interval is Student's t, with degrees of
    freedom by Satterthwaite. Percentiles of a bootstrap over a handful of searches would be too narrow.

    Args:
        a, b: of shape (searches, conditions), the conditions the same, the searches independent;
            nan where a run does not count. A condition counts where each law has a run that does.
        confidence: of the interval.

    Source: Satterthwaite 1946, doi:10.2307/3002019; Owen 2007, The pigeonhole bootstrap,
    doi:10.1214/07-AOAS122, on means over two crossed draws.

    Fails: with one search or one condition nothing tells the law from luck, and the interval is infinite;
    where few conditions of a long-tailed kind hold the difference.
    """
    counted = ~(np.isnan(a).all(axis=0) | np.isnan(b).all(axis=0))
    if not counted.any():
        return UNKNOWN
    a, b = a[:, counted], b[:, counted]
    each = np.nanmean(a, axis=0) - np.nanmean(b, axis=0)
    return interval(float(each.mean()), parts(each, a, b), confidence)


def spread(a: Numbers) -> float:
    """The variance of one law's mean over searches and conditions; inf where there is one of either."""
    counted = ~np.isnan(a).all(axis=0)
    each = np.nanmean(a[:, counted], axis=0)
    variance, _ = total(*parts(each, a[:, counted]))
    return variance


class Part(NamedTuple):
    """A part of a variance, and its degrees of freedom."""

    variance: float
    freedom: int


def parts(each: Numbers, *laws: Numbers) -> tuple[list[Part], float]:
    """The parts of the variance: that of the conditions, then of each law's searches; and what is in both."""
    shared = 0.0
    found = [mean_of(each)]
    for law in laws:
        rest = law - np.nanmean(law, axis=0)
        counted = ~np.isnan(rest)
        rest = rest[counted.any(axis=1)]
        searches = np.nanmean(rest, axis=1)
        found.append(mean_of(searches))
        freedom = (len(rest) - 1) * (law.shape[1] - 1)
        if freedom > 0:
            both = rest - searches[:, None]
            shared += float(np.nansum(both**2)) / freedom / int(counted.sum())
    return found, shared


def mean_of(values: Numbers) -> Part:
    """The variance of the mean of some draws."""
    if values.size < 2:
        return Part(np.inf, 0)
    return Part(float(values.var(ddof=1)) / values.size, values.size - 1)


def total(found: list[Part], shared: float) -> tuple[float, float]:
    """The variance that parts come to, and its degrees of freedom."""
    conditions, searches = found[0].variance, math.fsum(one.variance for one in found[1:])
    variance = max(conditions + searches - shared, conditions, searches)
    if not 0.0 < variance < np.inf:
        return variance, 0.0
    return variance, variance**2 / math.fsum(one.variance**2 / one.freedom for one in found)


def interval(value: float, found: tuple[list[Part], float], confidence: float) -> Difference:
    """A difference with its interval, from the parts of its variance."""
    from scipy.stats import t

    variance, freedom = total(*found)
    if variance == np.inf:
        return Difference(value, -np.inf, np.inf, 1.0)
    if variance == 0.0:
        return Difference(value, value, value, 1.0 if value == 0.0 else LEAST)
    error = variance**0.5
    half = float(t.ppf(0.5 + confidence / 2.0, freedom)) * error
    chance = 2.0 * float(t.sf(abs(value) / error, freedom))
    return Difference(value, value - half, value + half, max(chance, LEAST))
