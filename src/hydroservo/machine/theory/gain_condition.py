"""A switching gain must exceed the disturbance that its observer is to follow."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hydroservo.machine.theory.ranges import require_not_negative


class GainCondition(NamedTuple):
    """Whether a switching gain exceeds a disturbance, and by how much."""

    largest: float  # max |d_Li| on the run, in the unit of D_i
    margin: float  # D_i / max |d_Li|; above 1 the condition holds
    holds: bool


def gain_condition(switching_gain: float, disturbance: ArrayLike) -> GainCondition:
    """The condition D_i > max |d_Li| on a sampled disturbance.

    margin_i = D_i / max |d_Li|

    Args:
        switching_gain: D_i [m/s^2 or N/s], at least 0.
        disturbance: d_Li in the same unit, any shape; samples that are not numbers (after a divergence) are
            left out. Where none is left, the margin is nan and the condition does not hold.

    Raises:
        ParameterError: a negative gain.

    Source: Lemma 2 of doi:10.1007/s42401-021-00087-w.
    Fails to prove anything off the run: the lemma asks for all times, and a sampled maximum is a lower bound.
    """
    require_not_negative("switching_gain", switching_gain)
    sizes = np.abs(np.asarray(disturbance, dtype=np.float64))
    largest = float(np.max(sizes, where=~np.isnan(sizes), initial=-math.inf))
    if largest < 0.0:
        return GainCondition(math.nan, math.nan, False)
    margin = switching_gain / largest if largest > 0.0 else math.inf
    return GainCondition(largest, margin, switching_gain > largest)
