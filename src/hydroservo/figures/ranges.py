"""The ranges of axes: how large curves are, with or without their spikes."""

import math
from collections.abc import Sequence

import numpy as np

from hydroservo.figures.trace import Samples
from hydroservo.formatting import readable_unit

MARGIN = 0.12  # of a range, above and below
SMALLER = {"mm": "µm", "mm/s": "µm/s", "mV": "µV", "mA": "µA"}  # by a factor of 1000


def largest(curves: Sequence[Samples], tail: float = 0.0) -> float:
    """The largest size of all samples of all curves but a tail at either end of each; 0 without any."""
    low, high = extent(curves, tail)
    return max(abs(low), abs(high)) if low <= high else 0.0


def limits(curves: Sequence[Samples], tail: float) -> tuple[float, float]:
    """A range that holds all samples of all curves but a tail at either end of each, with a margin."""
    low, high = extent(curves, tail)
    if low > high:
        return -1.0, 1.0
    margin = MARGIN * (high - low) or MARGIN * abs(high) or 1.0
    return low - margin, high + margin


def extent(curves: Sequence[Samples], tail: float) -> tuple[float, float]:
    """The least and the largest sample but for tails; inf and -inf where there is none."""
    finite = [values[np.isfinite(values)] for values in curves]
    finite = [values for values in finite if values.size]
    low = min((float(np.quantile(values, tail)) for values in finite), default=math.inf)
    high = max((float(np.quantile(values, 1.0 - tail)) for values in finite), default=-math.inf)
    return low, high


def axis_unit(unit: str, largest: float) -> tuple[str, float]:
    """The unit of an axis and the factor to it; powers of ten go into the unit, not onto the ticks."""
    label, factor = readable_unit(unit, largest)
    if factor * largest >= 0.01:
        return label, factor
    return SMALLER.get(label, f"10⁻³ {label}"), 1e3 * factor
