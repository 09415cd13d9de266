"""A function compiled as kernels are, to be called from Python."""

from collections.abc import Callable
from typing import Any

from numba import njit

from hydroservo.engine import machine_code  # noqa: F401 - teaches numba the arithmetic on states
from hydroservo.engine.jit import CONTRACT

__all__ = ["compiled"]


def compiled(function: Callable[..., Any], *, strict: bool = True) -> Callable[..., Any]:
    """A function that may call methods of blocks, ops and the arithmetic on states."""
    dispatcher: Callable[..., Any] = njit(error_model="numpy", fastmath=set() if strict else CONTRACT)(
        function
    )
    return dispatcher
