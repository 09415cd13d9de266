"""Powers with any exponent."""

import math

from hydroservo.ops.basic import absolute, clip, copysign, nearest, where
from hydroservo.ops.binary import exponent, mantissa, scaled

__all__ = ["exp2_less_1", "power", "signed_power"]

LEAST_NORMAL = 2.2250738585072014e-308
SPLITTER = 134217729.0  # 2^27 + 1, Veltkamp: splits a number into halves whose products are exact
BEYOND = 2000.0  # an exponent of two that overflows or underflows for certain
STEEPEST = 1e20  # an exponent that takes every x but 1 there


def power(x: float, y: float) -> float:
    """x^y for x >= 0; nan for others. An infinite y is taken as the limit.

    With x = 2^e m, m in [sqrt(1/2), sqrt(2)), it is 2^n 2^(y e + y log2 m - n) for the whole n nearest to
    y log2 x; y e - n is formed without rounding. The relative error is below 3e-16 (1 + |y|) wherever the
    result is a normal number; a subnormal one is off by at most one unit in its last place.
    """
    p = clip(y, -STEEPEST, STEEPEST)
    size = absolute(x)
    small = size < LEAST_NORMAL
    normal = where(small, size * 18014398509481984.0, size)  # 2^54
    e = where(small, exponent(normal) - 54.0, exponent(normal))
    log2m = log2_mantissa(mantissa(normal))
    whole = nearest(clip(p * (e + log2m), -BEYOND, BEYOND))
    carry = SPLITTER * p
    high = carry - (carry - p)
    rest = (high * e - whole) + ((p - high) * e + p * log2m)
    result = scaled(1.0 + exp2_less_1(clip(rest, -1.0, 1.0)), whole)
    large = where(y > 0.0, math.inf, where(y < 0.0, 0.0, y + 1.0))
    least = where(y > 0.0, 0.0, where(y < 0.0, math.inf, y + 1.0))
    found = where(x > 0.0, where(x < math.inf, result, large), least)
    return where(x >= 0.0, found, math.nan)


def signed_power(x: float, y: float) -> float:
    """|x|^y sgn(x): the odd power that the paper writes x^(p/q) with p and q odd."""
    return copysign(power(absolute(x), y), x)


def log2_mantissa(m: float) -> float:
    """log2 m for m in [sqrt(1/2), sqrt(2)].

    A minimax polynomial (Remez) of log2((1 + s)/(1 - s))/s in s^2, with s = (m - 1)/(m + 1) and a
    relative error of 1.2e-18.
    """
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    z2 = z * z
    low = (0.9617966939259898 + z * 0.5770780163454704) + z2 * (0.41219858585106456 + z * 0.3205985339264623)
    high = (0.26233440174514827 + z * 0.22091186685788852) + z2 * 0.21367077946267188
    return s * (2.8853900817779268 + z * (low + z2 * z2 * high))


def exp2_less_1(f: float) -> float:
    """2^f - 1 for |f| <= 1/2, by a minimax polynomial (Remez) of (2^f - 1)/f with an error of 1.3e-17."""
    f2 = f * f
    f4 = f2 * f2
    low = (0.05550410866482166 + f * 0.009618129107606885) + f2 * (
        0.0013333558146396004 + f * 0.00015403530441741647
    )
    middle = (1.5252733853280778e-05 + f * 1.3215442584937203e-06) + f2 * (
        1.0178051728089911e-07 + f * 7.07258647985202e-09
    )
    series = low + f4 * (middle + f4 * 4.456675463639861e-10)
    return f * (0.6931471805599453 + f * (0.24022650695910097 + f * series))
