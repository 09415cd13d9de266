"""The two parts of a floating-point number: taken apart and put together."""

import math

from hydroservo.core.ops.basic import absolute

ROOT_HALF = 0.7071067811865476
BEYOND = 2000.0


def exponent(x: float) -> float:
    """The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2)); for normal x > 0."""
    half, e = math.frexp(x)
    return float(e - 1 if half < ROOT_HALF else e)


def mantissa(x: float) -> float:
    """The m in [sqrt(1/2), sqrt(2)) for which x = 2^e m; for normal x > 0."""
    half, _ = math.frexp(x)
    return 2.0 * half if half < ROOT_HALF else half


def scaled(x: float, n: float) -> float:
    """x 2^n, rounded once, for x in [1/2, 2] and whole n in [-2000, 2000]; of no meaning for other n."""
    if not absolute(n) <= BEYOND:
        return math.nan
    half = int(n) // 2
    return x * math.ldexp(1.0, half) * math.ldexp(1.0, int(n) - half)
