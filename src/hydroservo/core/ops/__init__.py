"""Scalar maths with one meaning: interpreted, compiled and traced.

Blocks use these instead of ``math`` and ``if``. All but the square root are made of additions,
multiplications, divisions, choices, the binary parts of a number and, for random ones, arithmetic on
whole numbers, so that every platform and compiler gives the same bits and compiled code can run many
lanes at once. Where Python's ``math`` raises, they return nan or inf; random numbers have no place for
a nan, and raise.
"""

from hydroservo.core.ops.basic import (
    absolute,
    at_or_after,
    clip,
    copysign,
    floor,
    isfinite,
    isnan,
    maximum,
    minimum,
    nearest,
    reached,
    sign,
    sqrt,
    square_wave,
    where,
)
from hydroservo.core.ops.circular import cos, sin
from hydroservo.core.ops.hyperbolic import tanh
from hydroservo.core.ops.power import power, power_root, signed_power, smooth_root
from hydroservo.core.ops.random import normal, uniform

__all__ = [
    "absolute",
    "at_or_after",
    "clip",
    "copysign",
    "cos",
    "floor",
    "isfinite",
    "isnan",
    "maximum",
    "minimum",
    "nearest",
    "normal",
    "power",
    "power_root",
    "reached",
    "sign",
    "signed_power",
    "sin",
    "smooth_root",
    "sqrt",
    "square_wave",
    "tanh",
    "uniform",
    "where",
]
