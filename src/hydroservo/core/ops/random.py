"""Random numbers that are functions of where they are drawn, with no state to carry."""

import math

from hydroservo.core.ops.basic import floor, sqrt, where
from hydroservo.core.ops.binary import exponent, mantissa
from hydroservo.core.ops.circular import cos, sin
from hydroservo.core.ops.power import LN_2, log2_mantissa

Words = tuple[int, int, int, int]  # of 32 bits

WORD = 0xFFFFFFFF
ROUNDS = 10
MULTIPLIERS = 0xD2511F53, 0xCD9E8D57
KEY_STEPS = 0x9E3779B9, 0xBB67AE85  # the golden ratio and sqrt(3), less 1, times 2^32
UNIFORM, NORMAL = 0, 1  # the last word of the counter: the two kinds of numbers share no bits


def uniform(seed: float, stream: float, index: float) -> float:
    """A number drawn evenly from [0, 1), a multiple of 2^-53.

    It is a function of its arguments alone, the same bits everywhere. Numbers of other seeds, streams
    or indices are independent of it, and so is :func:`normal` of the same ones.

    Args:
        seed: whole number in [0, 2^53), one for each run.
        stream: whole number in [0, 2^32), one for each source of randomness in a run.
        index: whole number in [0, 2^53), one for each draw from a source.

    Source: Philox4x32-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    Fails where numbers must be secret.
    """
    first, _ = drawn(seed, stream, index, UNIFORM)
    return first


def normal(seed: float, stream: float, index: float) -> float:
    """A number drawn from the normal distribution with mean 0 and standard deviation 1.

    With U in (0, 1] and V in [0, 1) drawn evenly, streams 2j and 2j+1 are the two coordinates of one point::

        sqrt(-2 ln U) (cos 2 pi V, sin 2 pi V)

    which are independent of each other. Arithmetic adds an error below 1.5e-15 sqrt(-2 ln U). Arguments
    and generator are those of :func:`uniform`.

    Source: Box, Muller 1958, doi:10.1214/aoms/1177706645.
    Fails beyond 8.57 standard deviations, since U is at least 2^-53; one number in 1e17 lies there.
    """
    pair = floor(0.5 * stream)
    first, second = drawn(seed, pair, index, NORMAL)
    u = 1.0 - first
    radius = sqrt(-2.0 * LN_2 * (exponent(u) + log2_mantissa(mantissa(u))))
    angle = 2.0 * math.pi * second
    return radius * where(stream == 2.0 * pair, cos(angle), sin(angle))


def drawn(seed: float, stream: float, index: float, kind: int) -> tuple[float, float]:
    """Two numbers drawn evenly from [0, 1), from the four words of one draw."""
    a, b, c, d = philox(position(stream, index, kind), low_and_high(seed))
    return fraction(a, b), fraction(c, d)


def position(stream: float, index: float, kind: int) -> Words:
    """The counter of a draw."""
    low, high = low_and_high(index)
    return low, high, int(stream), kind


def low_and_high(x: float) -> tuple[int, int]:
    """The two words of a whole number below 2^53."""
    high = floor(x * 2.0**-32)
    return int(x - high * 2.0**32), int(high)


def fraction(a: int, b: int) -> float:
    """The number in [0, 1) that has 27 bits of one word behind the point and then 26 of the other."""
    return (float(a >> 5) * 67108864.0 + float(b >> 6)) * 2.0**-53


def philox(counter: Words, key: tuple[int, int]) -> Words:
    """Philox4x32-10: a bijection of the counter for each key.

    A product of two words fills 64 bits; where that is a signed number it wraps, and the mask takes away
    what the shift then drags in from the sign.
    """
    a, b, c, d = counter
    k, q = key
    for _ in range(ROUNDS):
        first, second = MULTIPLIERS[0] * a, MULTIPLIERS[1] * c
        a, b, c, d = (second >> 32 & WORD) ^ b ^ k, second & WORD, (first >> 32 & WORD) ^ d ^ q, first & WORD
        k, q = (k + KEY_STEPS[0]) & WORD, (q + KEY_STEPS[1]) & WORD
    return a, b, c, d
