"""Choices, comparisons and roundings."""

import math

ROUNDED = 1.0 - 3.0 * 2.0**-52  # what adding up steps takes from an instant at most, and a little more
ROUNDER = 6755399441055744.0  # 1.5 * 2^52: adding it leaves no bits behind the point


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


def floor(x: float) -> float:
    """Largest whole number not above ``x``, as a float; nan and inf pass through."""
    return math.copysign(float(math.floor(x)), x) if isfinite(x) else x


def nearest(x: float) -> float:
    """The nearest whole number, the even one of two; for |x| below 2^51."""
    return (x + ROUNDER) - ROUNDER


def at_or_after(t: float, instant: float) -> bool:
    """True from the instant on, but for a few units in the last place: a step's end may be rounded down."""
    return t >= ROUNDED * instant


def reached(t: float, instant: float) -> bool:
    """True from the instant on, or a 1e-9 of it before: a sample meant to fall on it may be rounded down.

    What acts between samples takes :func:`at_or_after`: early by a part of the time is an error that grows.
    """
    return t >= (1.0 - 1e-9) * instant


def square_wave(t: float, period: float) -> float:
    """+1 in the first half of each period, -1 in the second.

    Switching instants within 1e-9 half periods of ``t`` count as reached, so that a sample meant to fall
    on one is not left behind by rounding.
    """
    half = floor(2.0 * t / period + 1e-9)
    return where(half - 2.0 * floor(0.5 * half) == 0.0, 1.0, -1.0)
