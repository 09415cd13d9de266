"""Does the surface of a sliding mode decrease as its proof says?"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.machine.theory.finite_time import decayed
from hydroservo.machine.theory.ranges import require_not_negative

ROUNDING = 1e-9  # of V: what rounding may add to a decrease that holds with equality


class Decrease(NamedTuple):
    """The decrease of V = s^2/2 over each interval between two samples."""

    residual: NDArray[np.float64]  # mean of dV/dt + mu V + delta V^alpha, [unit of s]^2/s
    judged: NDArray[np.bool_]  # False where both ends lie in the dead zone
    holds: NDArray[np.bool_]  # judged, and the residual is not above 0
    fraction: float  # of the judged intervals in which it holds; nan if s never left the dead zone


def decrease(
    time: ArrayLike,
    surface: ArrayLike,
    linear_gain: float,
    power_gain: float,
    exponent: float,
    dead_zone: float,
) -> Decrease:
    """The decrease of V = s^2/2 that a terminal reaching law promises, checked between samples of s.

    ds/dt = -k s - eps |s|^a sgn(s), or faster, means::

        dV/dt + 2 k V + 2^((1 + a)/2) eps V^((1 + a)/2) <= 0

    Over an interval h between samples this demands V_(n+1) <= V*(h), where V* starts at V_n and meets the
    condition with equality (:func:`hydroservo.machine.theory.decayed`). The residual is (V_(n+1) - V*(h))/h.
    It tends to the left side above as h goes to 0, and carries no difference error for any h.

    What a sampled loop can show is limited. Its law acts once a period T, in which a disturbance d and the
    switching gain D move the surface by up to T (D + |d|); V below (T (D + |d|))^2/2 cannot be told from
    0. So |s| within ``dead_zone`` counts as 0, and an interval with both ends there is not judged.
    Entering the dead zone counts as reaching the surface, leaving it as a violation. Where s stops being a
    number outside the dead zone, that interval is a violation and the rest is not judged.

    Args:
        time: instants of the samples [s], shape (n,), rising, n at least 2; apart by any number of periods.
        surface: samples of s, shape (n,).
        linear_gain: k [1/s], above 0.
        power_gain: eps [unit of s^(1 - a)/s], above 0.
        exponent: a, above 0 and below 1.
        dead_zone: in the unit of s, at least 0.

    Raises:
        ParameterError: an argument out of range, or fewer than two samples.

    Source: eqs. (16)-(17) and (24)-(25) of doi:10.1007/s42401-021-00087-w. (17) prints k V for 2 k V: weaker,
    and met by half the linear gain.
    Fails to see what happens between samples. A law that is itself a backward Euler step decays by
    1/(1 + k T) a period, which falls short of e^(-k T) by (k T)^2/2: a violation if D has no room to spare.
    """
    require_not_negative("dead_zone", dead_zone)
    t, s = np.asarray(time, dtype=np.float64), np.asarray(surface, dtype=np.float64)
    if s.ndim != 1 or s.size < 2 or t.shape != s.shape:
        raise ParameterError("surface", s.shape, "must be one row of at least two samples, as long as time")
    value = 0.5 * np.where(np.abs(s) <= dead_zone, 0.0, s) ** 2
    before, after = value[:-1], value[1:]
    alpha = 0.5 * (1.0 + exponent)
    allowed = decayed(before, 2.0 * linear_gain, 2.0**alpha * power_gain, alpha, np.diff(t))
    judged = (before > 0.0) | (after > 0.0)
    holds = judged & (after <= allowed + ROUNDING * before)
    count = np.count_nonzero(judged)
    fraction = float(np.count_nonzero(holds) / count) if count else math.nan
    return Decrease((after - allowed) / np.diff(t), judged, holds, fraction)
