"""Functions of ``ops`` without the bits of numbers, for languages such as Structured Text.

They give the same bits: exponents come from comparisons with exact powers of two, and the sign of a zero is
that of its reciprocal. Each is in the language of blocks.
"""

import math
from typing import NamedTuple

from hydroservo.core.ops.binary import BEYOND, ROOT_HALF

WHOLE = 4503599627370496.0  # 2^52: from here on every number is whole
LARGE, SMALL, LARGE_EXPONENT = 2.0**64, 2.0**-64, 64.0  # steps towards 1
TURNS = 17  # of them, from the smallest number to the largest
POWERS = tuple((float(k), 2.0**k, 2.0**-k) for k in (32, 16, 8, 4, 2, 1))


class NumberParts(NamedTuple):
    """A number as 2^exponent times its mantissa."""

    mantissa: float
    exponent: float


def absolute(x: float) -> float:
    """The size of x; 0.0 for both zeros."""
    if x > 0.0:
        return x
    return -x if x < 0.0 else x * x


def is_infinite(x: float) -> bool:
    """True for the infinite numbers."""
    return x == x and x - x != 0.0  # noqa: PLR0124 - false of nan


def copysign(magnitude: float, x: float) -> float:
    """``magnitude`` with the sign of ``x`` (that of a zero included)."""
    size = absolute(magnitude)
    if x == 0.0:
        return -size if 1.0 / x < 0.0 else size
    return -size if x < 0.0 else size


def floor(x: float) -> float:
    """Largest whole number not above ``x``, as a float; nan and inf pass through."""
    size = absolute(x)
    if not size < WHOLE:
        return x
    near = copysign((size + WHOLE) - WHOLE, x)
    return near - 1.0 if near > x else near


def number_parts(x: float) -> NumberParts:
    """The parts of a normal x > 0, with a mantissa from sqrt(1/2) to sqrt(2)."""
    m, e = x, 0.0
    for _ in range(TURNS):
        if m < LARGE:
            break
        m, e = m * SMALL, e + LARGE_EXPONENT
    for _ in range(TURNS):
        if m >= 1.0:
            break
        m, e = m * LARGE, e - LARGE_EXPONENT
    for k, power, inverse in POWERS:
        if m >= power:
            m, e = m * inverse, e + k
    if 0.5 * m < ROOT_HALF:
        return NumberParts(m, e)
    return NumberParts(0.5 * m, e + 1.0)


def exponent(x: float) -> float:
    """The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2)); for normal x > 0."""
    return number_parts(x).exponent


def mantissa(x: float) -> float:
    """The m in [sqrt(1/2), sqrt(2)) for which x = 2^e m; for normal x > 0."""
    return number_parts(x).mantissa


def power_of_two(n: float) -> float:
    """2^n for a whole n that gives a normal number."""
    size, power = absolute(n), 1.0
    for _ in range(TURNS):
        if size < LARGE_EXPONENT:
            break
        size, power = size - LARGE_EXPONENT, power * LARGE
    for k, factor, _ in POWERS:
        if size >= k:
            size, power = size - k, power * factor
    return 1.0 / power if n < 0.0 else power


def scaled(x: float, n: float) -> float:
    """x 2^n, rounded once, for x in [1/2, 2] and whole n in [-2000, 2000]; of no meaning for other n."""
    if not absolute(n) <= BEYOND:
        return math.nan
    half = floor(0.5 * n)
    return x * power_of_two(half) * power_of_two(n - half)


def remainder(a: float, b: float) -> float:
    """What is left of ``a`` after whole multiples of ``b``, exactly, with the sign of ``a``: C's fmod."""
    rest, part = absolute(a), absolute(b)
    if not (rest - rest == 0.0 and part > 0.0):
        return math.nan
    if part - part == 0.0:
        while part <= 0.5 * rest:
            part = 2.0 * part
        while part >= absolute(b):
            if rest >= part:
                rest = rest - part
            part = 0.5 * part
    return copysign(rest, a)
