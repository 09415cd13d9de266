"""Arrays by their addresses, which the engine keeps in a table beside the numbers of blocks."""

import ctypes
import math

import numpy as np
from numpy.typing import NDArray


def array_at(address: int, lengths: tuple[int, ...]) -> NDArray[np.float64]:
    """The array of doubles at an address; whoever gives it keeps that memory alive."""
    memory = (ctypes.c_double * math.prod(lengths)).from_address(int(address))
    return np.ctypeslib.as_array(memory).reshape(lengths)
