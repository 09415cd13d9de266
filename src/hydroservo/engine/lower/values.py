"""What a name can stand for while functions are lowered.

A number that is known is a Python number, one that is not is a :class:`Scalar`. A block is a tree of them
that never stands in memory. Classes, functions and modules stand for themselves.
"""

from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import numpy as np

DOUBLE = "double"  # LLVM's names of types
INTEGER = "i64"
BOOL = "i1"
ADDRESS = "ptr"
PYTHON_TYPES: dict[str, type] = {DOUBLE: float, INTEGER: int, BOOL: bool}
WORD = 2**64
WAY_OUT = "methods call only ops, each other and nested blocks, and give every field"


class LoweringError(Exception):
    """A text cannot be lowered; the message says why, and what to write instead."""

    def __init__(self, problem: str, hint: str = "") -> None:
        self.hint = hint or WAY_OUT
        super().__init__(problem)


class Scalar:
    """A number or an address that is known once the code runs: its LLVM type, and its name there."""

    __slots__ = ("kind", "text")

    def __init__(self, kind: str, text: str) -> None:
        self.kind, self.text = kind, text


class Composite:
    """Values side by side."""

    __slots__ = ("parts",)

    def __init__(self, parts: Sequence[Any]) -> None:
        self.parts = tuple(parts)

    def like(self, other: Any) -> bool:
        """Whether another value has the same structure."""
        return type(other) is type(self) and len(other.parts) == len(self.parts)

    def with_parts(self, parts: Sequence[Any]) -> "Composite":
        """The same structure of other values."""
        return type(self)(parts)


class Record(Composite):
    """A block, a state or a tuple."""

    __slots__ = ("cls",)

    def __init__(self, cls: type, parts: Sequence[Any]) -> None:
        super().__init__(parts)
        self.cls: Any = cls

    def like(self, other: Any) -> bool:
        return super().like(other) and other.cls is self.cls

    def with_parts(self, parts: Sequence[Any]) -> "Record":
        return Record(self.cls, parts)


class Array(Composite):
    """A contiguous array of doubles: its address and its lengths."""

    __slots__ = ()

    @property
    def lengths(self) -> tuple[Any, ...]:
        """How many there are along each axis."""
        return self.parts[1:]


class Pointer:
    """Memory of numbers of one LLVM type, of which nobody knows the end."""

    __slots__ = ("element", "text")

    def __init__(self, element: str, text: str) -> None:
        self.element, self.text = element, text


class Bound:
    """A method and the block that it was taken from."""

    __slots__ = ("function", "owner")

    def __init__(self, function: FunctionType, owner: Record) -> None:
        self.function, self.owner = function, owner


def is_number(value: Any) -> bool:
    """Whether it is a number, known or not."""
    if isinstance(value, Scalar):
        return value.kind != ADDRESS
    return isinstance(value, (bool, int, float))


def kind_of(value: Any) -> str:
    """The LLVM type of a number."""
    if isinstance(value, Scalar):
        return value.kind
    return BOOL if isinstance(value, bool) else INTEGER if isinstance(value, int) else DOUBLE


def operand(value: Any) -> str:
    """A number of its own kind as an operand."""
    if isinstance(value, Scalar):
        return value.text
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(wrapped(value))
    return f"0x{np.float64(value).view(np.uint64):016X}"


def wrapped(value: int) -> int:
    """A whole number in 64 bits with a sign."""
    return (value + WORD // 2) % WORD - WORD // 2


def unified(kinds: Sequence[str]) -> str:
    """The kind that numbers of some kinds become where they meet."""
    found = set(kinds)
    if len(found) == 1:
        return kinds[0]
    if ADDRESS in found:
        raise LoweringError("a number and an array meet under one name")
    return DOUBLE if DOUBLE in found else INTEGER


def same(a: Any, b: Any) -> bool:
    """Whether two values are one for certain."""
    if a is b:
        return True
    if isinstance(a, Scalar) and isinstance(b, Scalar):
        return a.text == b.text
    if isinstance(a, Composite):
        return a.like(b) and all(map(same, a.parts, b.parts))
    if isinstance(a, Bound) and isinstance(b, Bound):
        return a.function is b.function and same(a.owner, b.owner)
    return type(a) is type(b) and isinstance(a, (bool, int, float)) and operand(a) == operand(b)


def lifted(value: Any) -> Any:
    """What a Python object is while functions are lowered."""
    if isinstance(value, tuple):
        return Record(type(value), [lifted(part) for part in value])
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, float):
        return float(value)
    function: Callable[..., Any] | None = getattr(value, "py_func", None)  # of what was compiled already
    return value if function is None else function
