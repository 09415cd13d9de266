"""Numbers compared bit for bit."""

import math
import struct
from typing import Any

import numpy as np

from hydroservo.core.block import is_block, leaves

CANONICAL_NAN = struct.pack("<d", float("nan"))


def bits(value: Any) -> Any:
    """What makes a number, an array, a block or a state the same to the last bit; all nan are one."""
    if is_block(value):
        return type(value).__name__, tuple((path, bits(leaf)) for path, leaf in leaves(value))
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, float):
        return CANONICAL_NAN if math.isnan(value) else struct.pack("<d", value)
    return type(value), value


def numbers_in_result(value: Any) -> list[float]:
    """Every number in a result."""
    return [number for _, number in leaves(value)] if is_block(value) else [value]
