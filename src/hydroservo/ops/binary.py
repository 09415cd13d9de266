"""The two parts of a floating-point number."""

import math

__all__ = ["exponent", "mantissa", "two_to"]

ROOT_HALF = 0.7071067811865476


def exponent(x: float) -> float:
    """The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2)); for normal x > 0."""
    half, e = math.frexp(x)
    return float(e - 1 if half < ROOT_HALF else e)


def mantissa(x: float) -> float:
    """The m in [sqrt(1/2), sqrt(2)) for which x = 2^e m; for normal x > 0."""
    half, _ = math.frexp(x)
    return 2.0 * half if half < ROOT_HALF else half


def two_to(n: float) -> float:
    """2^n for whole n in [-1022, 1023]; nan for nan."""
    return math.ldexp(1.0, int(n)) if n - n == 0.0 else n
