"""How far an axis goes: over what lines do, but for a few outliers, which are counted."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.formatting import number

Vector = NDArray[np.float64]

FEWEST = 30  # samples, of which one may be an outlier
SPIKES = 1e-3  # of the samples at either end that may be outliers, and three of few
LAST = 0.05  # of the samples of a run that is lost, the last of which are far from all others
FAR = 3.0  # times the span of all others, beyond which a sample is one
FLAT = 0.05  # of its size, which a line that hardly changes counts as spanning


class Extent(NamedTuple):
    """How far an axis goes.

    Attributes:
        low: the least value on it.
        high: the largest.
        outliers: how many samples lie beyond.
        least: of all samples.
        most: of all samples.
    """

    low: float
    high: float
    outliers: int
    least: float
    most: float


def extent_of(lines: Sequence[Vector], diverged: bool = False) -> Extent | None:
    """The extent of lines on common axes; None where they have no number.

    Args:
        lines: their values, nan where there is none.
        diverged: whether they are of a run that did.
    """
    rows = [one[np.isfinite(one)] for one in lines]
    rows = [one for one in rows if one.size]
    if not rows:
        return None
    cores = [range_without_outliers(one, LAST if diverged else SPIKES) for one in rows]
    low, high = min(one[0] for one in cores), max(one[1] for one in cores)
    room = FAR * max(high - low, FLAT * max(abs(low), abs(high)))
    every = np.concatenate(rows)
    inside = every[(every >= low - room) & (every <= high + room)] if room > 0.0 else every
    beside = every.size - inside.size
    return Extent(float(inside.min()), float(inside.max()), beside, float(every.min()), float(every.max()))


def outliers_text(extent: Extent, unit: str, factor: float) -> str:
    """What lies beyond an axis, such as "3 samples up to 41 bar"; "" if nothing does.

    Args:
        extent: of the axis, in SI units.
        unit: in which it is said.
        factor: to that from SI.
    """
    if not extent.outliers:
        return ""
    ends = [f"up to {number(factor * extent.most)} {unit}".strip()] if extent.most > extent.high else []
    ends += [f"down to {number(factor * extent.least)} {unit}".strip()] if extent.least < extent.low else []
    return f"{extent.outliers} sample{'s' if extent.outliers > 1 else ''} {' and '.join(ends)}"


def range_without_outliers(values: Vector, share: float) -> tuple[float, float]:
    """The least and the largest value, but for a share at either end."""
    if values.size < FEWEST:
        return float(values.min()), float(values.max())
    beside = max(3, int(share * values.size))
    places = beside, values.size - 1 - beside
    low, high = np.partition(values, places)[list(places)]
    return float(low), float(high)
