"""Scalar maths with one meaning: interpreted, compiled and traced.

Blocks use these instead of ``math`` and ``if``. They follow C99's functions of the same name: where
Python's ``math`` raises (the root of a negative number, an overflow), these return nan or inf, so
that an interpreted run and a compiled run agree bit for bit even when a loop diverges.
"""

import math

__all__ = [
    "absolute",
    "clip",
    "copysign",
    "cos",
    "floor",
    "isfinite",
    "isnan",
    "maximum",
    "minimum",
    "power",
    "sign",
    "signed_power",
    "sin",
    "sqrt",
    "square_wave",
    "tanh",
    "where",
]


def where(condition: bool, a: float, b: float) -> float:
    """``a`` if the condition holds, else ``b``; both are evaluated."""
    return a if condition else b


def absolute(x: float) -> float:
    """Absolute value."""
    return math.fabs(x)


def copysign(magnitude: float, x: float) -> float:
    """``magnitude`` with the sign of ``x`` (that of a zero included)."""
    return math.copysign(magnitude, x)


def isnan(x: float) -> bool:
    """True for not-a-number."""
    return x != x  # noqa: PLR0124 - true of nan alone


def isfinite(x: float) -> bool:
    """True unless infinite or not-a-number."""
    return x - x == 0.0


def sign(x: float) -> float:
    """-1, 0 or +1; 0 for not-a-number."""
    return where(x > 0.0, 1.0, where(x < 0.0, -1.0, 0.0))


def minimum(a: float, b: float) -> float:
    """The smaller; ``b`` where they do not compare."""
    return where(a < b, a, b)


def maximum(a: float, b: float) -> float:
    """The larger; ``b`` where they do not compare."""
    return where(a > b, a, b)


def clip(x: float, low: float, high: float) -> float:
    """``x`` within [low, high]; not-a-number passes through."""
    return where(x < low, low, where(x > high, high, x))


def sqrt(x: float) -> float:
    """Square root; nan below zero."""
    return math.sqrt(x) if x >= 0.0 else math.nan


def sin(x: float) -> float:
    """Sine of an angle [rad]; nan for an infinite one."""
    return math.sin(x) if isfinite(x) else math.nan


def cos(x: float) -> float:
    """Cosine of an angle [rad]; nan for an infinite one."""
    return math.cos(x) if isfinite(x) else math.nan


def tanh(x: float) -> float:
    """Hyperbolic tangent."""
    return math.tanh(x)


def floor(x: float) -> float:
    """Largest whole number not above ``x``, as a float; nan and inf pass through."""
    return float(math.floor(x)) if isfinite(x) else x


def power(x: float, exponent: float) -> float:
    """x**exponent as C's ``pow``: nan for a negative base with a broken exponent, inf on overflow."""
    try:
        return math.pow(x, exponent)
    except OverflowError:
        odd = math.fabs(math.fmod(exponent, 2.0)) == 1.0
        return math.copysign(math.inf, x) if odd else math.inf
    except ValueError:
        if x != 0.0:
            return math.nan
        odd = math.fabs(math.fmod(exponent, 2.0)) == 1.0
        return math.copysign(math.inf, x) if odd else math.inf


def signed_power(x: float, exponent: float) -> float:
    """|x|**exponent sgn(x): the odd power that the paper writes x^(p/q) with p and q odd."""
    return copysign(power(absolute(x), exponent), x)


def square_wave(t: float, period: float) -> float:
    """+1 in the first half of each period, -1 in the second.

    Switching instants within 1e-9 half periods of ``t`` count as reached, so that a sample meant to fall
    on one is not left behind by rounding.
    """
    half = floor(2.0 * t / period + 1e-9)
    return where(half - 2.0 * floor(0.5 * half) == 0.0, 1.0, -1.0)
