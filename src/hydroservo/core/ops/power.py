"""Powers with any exponent."""

import math

from hydroservo.core.ops.basic import absolute, clip, copysign, maximum, minimum, nearest, sqrt, where
from hydroservo.core.ops.binary import exponent, mantissa, scaled

LEAST_NORMAL = 2.2250738585072014e-308
SPLITTER = 134217729.0  # 2^27 + 1, Veltkamp: splits a number into halves whose products are exact
LN_2 = 0.6931471805599453
BEYOND = 1100.0  # an exponent of two that overflows or underflows for certain
NEWTON_STEPS = 6  # of power_root
STEEPEST = 1e20  # an exponent that takes every x but 1 there
LEAST_SQUARE = 1e-60  # keeps 0/0 away from a root without a transition


def power(x: float, y: float) -> float:
    """x^y for x >= 0; nan for others. An infinite y is taken as the limit.

    With x = 2^e m, m in [sqrt(1/2), sqrt(2)), it is 2^n 2^(y e + y log2 m - n) for the whole n nearest to
    y log2 x; y e - n is formed without rounding. The relative error is below 3e-16 (1 + |y|) wherever the
    result is a normal number; a subnormal one is off by at most one unit in its last place. A subnormal x
    counts as the least normal number, 2.2e-308.
    """
    p = clip(y, -STEEPEST, STEEPEST)
    normal = maximum(LEAST_NORMAL, absolute(x))
    e = exponent(normal)
    log2m = log2_mantissa(mantissa(normal))
    part = p * log2m
    total = p * e + part
    whole = nearest(total)
    carry = SPLITTER * p
    high = carry - (carry - p)
    f = (high * e - whole) + ((p - high) * e + part)
    result = scaled((1.0 + f * LN_2) + (f * f) * exp2_tail(f), whole)
    result = where(total > BEYOND, math.inf, where(total < -BEYOND, 0.0, result))
    large = where(y > 0.0, math.inf, where(y < 0.0, 0.0, y + 1.0))
    least = where(y > 0.0, 0.0, where(y < 0.0, math.inf, y + 1.0))
    found = where(x > 0.0, where(x < math.inf, result, large), least)
    return where(x >= 0.0, found, math.nan)


def signed_power(x: float, y: float) -> float:
    """|x|^y sgn(x): the odd power that the paper writes x^(p/q) with p and q odd."""
    return copysign(power(absolute(x), y), x)


def smooth_root(x: float, transition: float) -> float:
    """x/(x^2 + t^2)^(1/4): sgn(x) |x|^(1/2) for |x| far above the transition t, x/t^(1/2) far below it."""
    square = x * x + transition * transition
    return x / sqrt(sqrt(maximum(square, LEAST_SQUARE)))


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
    return s * 2.8853900817779268 + (s * z) * (low + z2 * z2 * high)


def exp2_tail(f: float) -> float:
    """(2^f - 1 - f ln 2)/f^2 for |f| <= 1/2: a minimax polynomial (Remez), 2^f to 1.3e-17."""
    f2 = f * f
    f4 = f2 * f2
    low = (0.24022650695910097 + f * 0.05550410866482166) + f2 * (
        0.009618129107606885 + f * 0.0013333558146396004
    )
    middle = (0.00015403530441741647 + f * 1.5252733853280778e-05) + f2 * (
        1.3215442584937203e-06 + f * 1.0178051728089911e-07
    )
    high = 7.07258647985202e-09 + f * 4.456675463639861e-10
    return low + f4 * (middle + f4 * high)


def power_root(rhs: float, linear: float, factor: float, a: float) -> float:
    """The one sigma >= 0 with linear sigma + factor sigma^a = rhs; 0 unless rhs > 0.

    It takes linear > 0, factor >= 0 and 0.1 <= a < 1.

    With w = sigma^a the left side is convex and rising in w, so Newton's method from the right falls
    monotonically onto the root; six steps reach rounding, whatever the numbers.
    """
    right = where(rhs > 0.0, rhs, 1.0)
    w = power(right / linear, a)
    for _ in range(NEWTON_STEPS):
        sigma = power(w, 1.0 / a)
        w = w * ((1.0 - a) * linear * sigma + a * right) / (linear * sigma + a * factor * w + LEAST_NORMAL)
    return where(rhs > 0.0, minimum(power(w, 1.0 / a), right / linear), 0.0)
