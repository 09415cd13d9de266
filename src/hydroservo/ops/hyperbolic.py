"""The hyperbolic tangent."""

from hydroservo.ops.basic import absolute, clip, copysign, where
from hydroservo.ops.power import scaled_exp2

__all__ = ["tanh"]

LOG2_E = 1.4426950408889634
LINEAR = 0.55  # below it by a polynomial, above it by the exponential


def tanh(x: float) -> float:
    """Hyperbolic tangent; the relative error is below 4e-16 everywhere.

    For |x| < 0.55 x + x^3 P(x^2) with a minimax polynomial (Remez) P, elsewhere 1 - 2/(e^(2|x|) + 1).
    """
    size = absolute(x)
    z = size * size
    z2 = z * z
    low = (-0.333333333333333 + z * 0.13333333333326622) + z2 * (
        -0.05396825396376053 + z * 0.0218694883858553
    )
    middle = (-0.008863232601454189 + z * 0.003592092030740616) + z2 * (
        -0.0014555428486536896 + z * 0.0005884445014980713
    )
    high = (-0.0002333816117094111 + z * 8.331652354841686e-05) - z2 * 1.9494739807310333e-05
    series = low + (z2 * z2) * (middle + (z2 * z2) * high)
    near = size + size * z * series
    far = 1.0 - 2.0 / (scaled_exp2(0.0, clip(2.0 * LOG2_E * size, 0.0, 64.0)) + 1.0)
    return copysign(where(size < LINEAR, near, where(size > 20.0, 1.0, far)), x)
