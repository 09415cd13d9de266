"""Lemma 1: how fast dV/dt <= -mu V - delta V^alpha brings V to zero."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.machine.theory.ranges import require_fraction, require_not_negative, require_positive


def settling_bound(
    linear_rate: float,
    power_rate: float,
    exponent: float,
    initial: float,
    start: float = 0.0,
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
