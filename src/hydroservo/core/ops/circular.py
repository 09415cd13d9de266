"""Sine and cosine."""

import math

from hydroservo.core.ops.basic import absolute, nearest, where

TWO_OVER_PI = 0.6366197723675814
# pi/2 in three parts; the first two have 26 bits, so that their products with the quadrant are exact
HALF_PI_HIGH = 1.5707963109016418
HALF_PI_MIDDLE = 1.5893254712295857e-08
HALF_PI_LOW = 6.123233995736766e-17
LARGEST = 2.0e8  # [rad] beyond it the quadrant has more bits than the products can hold


def sin(x: float) -> float:
    """Sine of an angle [rad]; the error is below 2e-16 for |x| < 2e8, and it is nan beyond."""
    quadrant = nearest(where(absolute(x) < LARGEST, x, 0.0) * TWO_OVER_PI)
    return turned(x, quadrant, quadrant)


def cos(x: float) -> float:
    """Cosine of an angle [rad]; the error is below 2e-16 for |x| < 2e8, and it is nan beyond."""
    quadrant = nearest(where(absolute(x) < LARGEST, x, 0.0) * TWO_OVER_PI)
    return turned(x, quadrant, quadrant + 1.0)


def turned(x: float, quadrant: float, phase: float) -> float:
    """The sine of phase quarter turns and what is left of x after its quadrant."""
    r = ((x - quadrant * HALF_PI_HIGH) - quadrant * HALF_PI_MIDDLE) - quadrant * HALF_PI_LOW
    z = r * r
    odd = -0.00019841269829816508 + z * (
        2.7557313695094906e-06 + z * (-2.5050758634958902e-08 + z * 1.5896826964911383e-10)
    )
    sine = r + r * z * (-0.16666666666666632 + z * (0.008333333333322424 + z * odd))
    even = 2.4801587289495832e-05 + z * (
        -2.7557314356142375e-07 + z * (2.0875723782034703e-09 - z * 1.1359673987890631e-11)
    )
    cosine = 1.0 - 0.5 * z + z * z * (0.0416666666666666 + z * (-0.0013888888888874146 + z * even))
    turns = phase - 4.0 * nearest(0.25 * phase)  # -2, -1, 0, 1 or 2 quarter turns
    size = where(absolute(turns) == 1.0, cosine, sine)
    value = where(turns == -1.0, -size, where(absolute(turns) == 2.0, -size, size))
    return where(absolute(x) < LARGEST, value, math.nan)
