"""A function compiled as kernels are, to be called from Python."""

import ctypes
from collections.abc import Callable, Iterator, Sequence
from types import FunctionType
from typing import Any

import numpy as np

from hydroservo.core.block import Block
from hydroservo.engine.flat import GIVEN
from hydroservo.engine.llvm.entries import method_text
from hydroservo.engine.machine_code import object_code
from hydroservo.engine.native import Linked, RunError
from hydroservo.language.terms import Array, Known

WORD = 8  # bytes


def compiled_function(function: Callable[..., Any], *, strict: bool = True) -> "Compiled":
    """A function that may call methods of blocks, ops and the arithmetic on states."""
    return Compiled(function, strict)


class Compiled:
    """A compiled function, with machine code of its own for each new combination of types."""

    def __init__(self, function: Any, strict: bool) -> None:
        self.py_func: FunctionType = function  # the function in plain Python
        self.strict = strict
        self.kernels: dict[Any, tuple[Linked, Any, int]] = {}  # what was compiled so far

    def __call__(self, *arguments: Any) -> Any:
        """What the function returns."""
        shapes = tuple(map(argument_shape, arguments))
        if shapes not in self.kernels:
            self.kernels[shapes] = self.made(shapes)
        kernel, returned, count = self.kernels[shapes]
        doubles: list[float] = []
        integers: list[int] = []
        for argument in arguments:
            gather(argument, doubles, integers)
        results = np.empty(count, dtype=np.int64)
        memory = np.array(doubles, dtype=np.float64), np.array(integers, dtype=np.int64), results
        if kernel.function(*(ctypes.c_void_p(row.ctypes.data) for row in memory)) != 0:
            raise RunError("a block raised an exception, which compiled code cannot carry")
        return returned_value(returned, iter(results))

    def made(self, shapes: tuple[Any, ...]) -> tuple[Linked, Any, int]:
        """The machine code for arguments of some shapes, the shape of what it returns, and its numbers."""
        name = "compiled"
        text, returned = method_text(name, self.py_func, shapes)
        return Linked(object_code(name, text, self.strict)), returned, len(list(number_types(returned)))


def argument_shape(value: Any, known: bool = False) -> Any:
    """The types of all that is in an argument; whole numbers and switches of blocks are known."""
    if isinstance(value, tuple):
        return (type(value), *(argument_shape(part, inside) for part, inside in tuple_parts(value)))
    if known and isinstance(value, int):
        return Known(value)
    if isinstance(value, np.ndarray):
        return (Array, value.shape if known else (None,) * value.ndim)
    return next((kind for kind in (bool, int, float) if isinstance(value, kind)), type(value))


def tuple_parts(value: tuple[Any, ...]) -> Iterator[tuple[Any, bool]]:
    """What a tuple holds, and whether it is part of the code."""
    names: Sequence[str] = getattr(value, "_fields", ())
    for i, part in enumerate(value):
        yield part, bool(names) and names[i] not in GIVEN


def gather(value: Any, doubles: list[float], integers: list[int], known: bool = False) -> None:
    """Adds the numbers of an argument to those before it, but for those that are known."""
    if isinstance(value, tuple):
        for part, inside in tuple_parts(value):
            gather(part, doubles, integers, inside)
    elif isinstance(value, np.ndarray):
        if value.dtype != np.float64 or not value.flags.c_contiguous:
            raise TypeError(f"compiled code takes contiguous arrays of doubles, not of {value.dtype}")
        integers += [value.ctypes.data, *value.shape]
    elif isinstance(value, float):
        doubles.append(value)
    elif value is not None and not (known and isinstance(value, int)):
        integers.append(int(value))


def number_types(shape: Any) -> Iterator[type]:
    if isinstance(shape, tuple):
        for part in shape[1:]:
            yield from number_types(part)
    elif not isinstance(shape, Known):
        yield shape


def returned_value(shape: Any, results: Iterator[np.int64]) -> Any:
    """What was returned, from 64 bits of each number."""
    if isinstance(shape, tuple):
        cls, *parts = shape
        found = [returned_value(part, results) for part in parts]
        block: Block = tuple(found) if cls is tuple else cls(*found)
        return block
    if isinstance(shape, Known):
        return shape.value
    bits = next(results)
    return float(bits.view(np.float64)) if shape is float else shape(bits)
