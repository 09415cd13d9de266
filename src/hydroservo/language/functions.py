"""Python's // and % on floats, and arrays by their addresses; printers have whole numbers of their own."""

import ctypes
import math

import numpy as np
from numpy.typing import NDArray

from hydroservo.core import ops


def modulo(a: float, b: float) -> float:
    """a - b floor(a/b), with the sign of b."""
    rest = math.fmod(a, b)
    turned = ops.where((rest < 0.0) != (b < 0.0), rest + b, rest)
    return ops.where(rest == 0.0, ops.copysign(0.0, b), turned)


def floor_quotient(a: float, b: float) -> float:
    """The largest whole number not above a/b; of a division by zero what the quotient is."""
    rest = math.fmod(a, b)
    ratio = (a - rest) / b
    below = rest != 0.0 and (rest < 0.0) != (b < 0.0)
    ratio = ops.where(below, ratio - 1.0, ratio)
    low = ops.floor(ratio)
    whole = ops.where(ratio - low > 0.5, low + 1.0, low)
    found = ops.where(ratio == 0.0, ops.copysign(0.0, a / b), whole)
    return ops.where(b == 0.0, a / b, found)


def whole_quotient(a: int, b: int) -> int:
    """The largest whole number not above a/b."""
    return a // b


def whole_modulo(a: int, b: int) -> int:
    """a - b floor(a/b), with the sign of b."""
    return a % b


def array_at(address: int, lengths: tuple[int, ...]) -> NDArray[np.float64]:
    """The array of doubles at an address; whoever gives it keeps that memory alive."""
    memory = (ctypes.c_double * math.prod(lengths)).from_address(int(address))
    return np.ctypeslib.as_array(memory).reshape(lengths)
