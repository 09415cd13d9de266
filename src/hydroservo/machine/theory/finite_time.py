"""Convergence in finite time: its bound, whether a trajectory shows it, and the gains that it takes."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.machine.theory.ranges import require_fraction, require_not_negative, require_positive


def settling_bound(
    linear_rate: float, power_rate: float, exponent: float, initial: float, start: float = 0.0
) -> float:
    """The instant t_f [s] by which a function V that decreases as in Lemma 1 is zero.

    With dV/dt + mu V + delta V^alpha <= 0 from t_0 on::

        t_f <= t_0 + 1/(mu (1 - alpha)) ln(1 + mu V(t_0)^(1 - alpha)/delta)

    With equality in the condition, t_f is that instant itself.

    Args:
        linear_rate: mu [1/s], above 0.
        power_rate: delta [V^(1 - alpha)/s], above 0.
        exponent: alpha, above 0 and below 1.
        initial: V(t_0), in the unit of V, at least 0.
        start: t_0 [s].

    Raises:
        ParameterError: an argument out of range.

    Source: eq. (8) of doi:10.1007/s42401-021-00087-w, of which W = V^(1 - alpha) makes a linear one,
    dW/dt <= -(1 - alpha) (mu W + delta); its eq. (9) prints 1 + alpha in the first factor.
    Fails as a forecast where the condition holds with much room to spare: it is an upper bound.
    """
    require_rates(linear_rate, power_rate, exponent)
    require_not_negative("initial", initial)
    ratio = linear_rate * initial ** (1.0 - exponent) / power_rate
    return start + math.log1p(ratio) / (linear_rate * (1.0 - exponent))


def decayed(
    initial: ArrayLike, linear_rate: float, power_rate: float, exponent: float, time: ArrayLike
) -> NDArray[np.float64]:
    """V after some time if it decreases no faster than Lemma 1 asks for.

    The solution of dV/dt = -mu V - delta V^alpha::

        V(t)^(1 - alpha) = max((V(0)^(1 - alpha) + delta/mu) e^(-mu (1 - alpha) t) - delta/mu, 0)

    By comparison, every V that meets Lemma 1's condition is at or below it.

    Args:
        initial: V(0), any shape, at least 0.
        linear_rate: mu [1/s], above 0.
        power_rate: delta [V^(1 - alpha)/s], above 0.
        exponent: alpha, above 0 and below 1.
        time: t [s], of a shape that broadcasts with ``initial``.

    Raises:
        ParameterError: a rate or the exponent out of range.

    Source: eq. (8) of doi:10.1007/s42401-021-00087-w, integrated with W = V^(1 - alpha).
    Fails close to extinction by rounding: W is the difference of two numbers as large as delta/mu.
    """
    require_rates(linear_rate, power_rate, exponent)
    complement = 1.0 - exponent
    power = np.asarray(initial, dtype=np.float64) ** complement
    passed = -linear_rate * complement * np.asarray(time, dtype=np.float64)
    left = power * np.exp(passed) + power_rate / linear_rate * np.expm1(passed)
    result: NDArray[np.float64] = np.maximum(left, 0.0) ** (1.0 / complement)
    return result


def require_rates(linear_rate: float, power_rate: float, exponent: float) -> None:
    require_positive("linear_rate", linear_rate)
    require_positive("power_rate", power_rate)
    require_fraction("exponent", exponent)


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
