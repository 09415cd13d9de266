"""The hyperbolic tangent."""

from hydroservo.core.ops.basic import absolute, copysign, minimum, nearest
from hydroservo.core.ops.binary import scaled
from hydroservo.core.ops.power import LN_2, exp2_tail

TWO_LOG2_E = 2.8853900817779268
ONE = 22.0  # from here on it is 1 to the last bit


def tanh(x: float) -> float:
    """Hyperbolic tangent; the relative error is below 5e-16 everywhere.

    It is g/(g + 2) with g = e^(2|x|) - 1 = 2^n (2^f - 1) + (2^n - 1), n whole and |f| <= 1/2.
    """
    y = TWO_LOG2_E * minimum(ONE, absolute(x))
    whole = nearest(y)
    f = y - whole
    power_of_two = scaled(1.0, whole)
    growth = power_of_two * (f * LN_2 + (f * f) * exp2_tail(f)) + (power_of_two - 1.0)
    return copysign(growth / (growth + 2.0), x)
