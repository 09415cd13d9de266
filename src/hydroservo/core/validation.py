"""Parameters are checked and made floats before any compiled code sees them.

Each number by itself first, then what a block says of its numbers together.
"""

import math
from functools import cache
from numbers import Integral, Real
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, in_signal, is_block, signal_below, signal_of
from hydroservo.core.curve import Curve, check_curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field, declared_fields

ARRAYS = (NDArray[np.float64], np.ndarray)
WHOLE, REAL = (int, Integral), (float, Real)  # what is usual first: an abstract class is slow to ask
TEXT = "is text: a block's parameter is a float, an int, a bool or a block"
LARGEST_WHOLE = 2**53  # kernels take whole numbers as doubles, which hold no larger ones


def checked(block: Block, path: str = "") -> Block:
    """A copy of a block, and all blocks nested in it, with parameters that are allowed and go together."""
    found = in_range(block, path)
    consistent(found, path)
    return found


def consistent(block: Block, path: str = "") -> None:
    """Ask a block, and all blocks nested in it, that have a method ``check`` whether their numbers agree."""
    for name, value in zip(block._fields, block, strict=True):
        if is_block(value):
            consistent(value, f"{path}.{name}" if path else name)
    if hasattr(block, "check"):
        check_own(block, path)


def check_own(block: Block, path: str) -> None:
    """Ask a block that has a method ``check``, and not those in it."""
    try:
        block.check()
    except ParameterError as error:
        here = f"{path}.{error.path}" if path else error.path
        raise ParameterError(here, error.value, error.allowed) from None
    except ArithmeticError as error:
        kind = type(block).__name__
        problem = f"has numbers out of all proportion: {error}"
        raise ParameterError(path or kind, kind, problem) from None
    except Exception as error:  # of a block that is a user's own
        kind = type(block).__name__
        problem = f"its method check fails: {type(error).__name__}: {error}"
        raise ParameterError(path or kind, kind, problem) from error


def in_range(block: Block, path: str = "", outer: Field | None = None) -> Block:
    """A copy of a block, and all blocks nested in it, with every parameter of its declared type and range.

    Args:
        block: the block.
        path: where it is, for the message.
        outer: the controlled signal of what it is in, whose unit the message may need; None if there is none.
    """
    values = []
    signal = signal_of(block, outer)
    for (name, field, kind, is_array), value in zip(declarations(block.__class__), block, strict=True):
        here = f"{path}.{name}" if path else name
        if is_block(value):
            values.append(in_range(value, here, signal_below(block, name, signal)))
        elif is_array or isinstance(value, np.ndarray):
            values.append(array(value, here, kind))
        else:
            values.append(checked_number(value, here, in_signal(field, signal), kind))
    found = type(block)(*values)
    if isinstance(found, Curve):
        check_curve(found, path)
    return found


class Declaration(NamedTuple):
    """What a block's class says of one of its fields."""

    name: str
    field: Field
    kind: Any  # its type
    is_array: bool


@cache
def declarations(cls: Any) -> tuple[Declaration, ...]:
    """What a class of blocks says of each field, in order."""
    fields, kinds = declared_fields(cls), get_type_hints(cls)
    return tuple(
        Declaration(name, fields.get(name, Field("", name)), kinds.get(name), kinds.get(name) in ARRAYS)
        for name in cls._fields
    )


def array(value: Any, path: str, kind: Any) -> NDArray[np.float64]:
    """A contiguous array of doubles with these values."""
    if kind in (float, int, bool):
        raise ParameterError(path, f"an array of shape {np.shape(value)}", "must be a single number")
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu":
        given = value.dtype if isinstance(value, np.ndarray) else type(value).__name__
        raise ParameterError(path, str(given), "must be an array of real numbers")
    return np.ascontiguousarray(value, dtype=np.float64)


def checked_number(value: Any, path: str, field: Field, kind: Any) -> float | int | bool:
    """One number of its declared kind (float, int or bool) and range; "auto" is the field's automatic one."""
    if kind is str:
        raise ParameterError(path, value, TEXT)
    if kind is bool:
        if not isinstance(value, (bool, np.bool_)):
            raise ParameterError(path, value, "must be true or false")
        return bool(value)
    whole = kind is int
    if field.auto is not None and value == "auto":
        return field.auto
    if not fits(value, field, whole):
        raise ParameterError(path, value, f"must be {allowed(field, whole)}")
    if whole and abs(value) > LARGEST_WHOLE:
        raise ParameterError(path, value, "must be a whole number between -2^53 and 2^53")
    return int(value) if whole else float(value)


def fits(value: Any, field: Field, whole: bool) -> bool:
    """True for a number of the right kind in a field's range."""
    if isinstance(value, bool) or not isinstance(value, WHOLE if whole else REAL):
        return False
    try:
        return within(float(value), field)
    except OverflowError:  # an integer beyond the largest float
        return False


def whole_number(name: str, value: object, least: int, most: int) -> int:
    """A whole number in a range."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise ParameterError(name, value, f"must be a whole number from {least} to {most}")
    return int(value)


def within(value: float, field: Field) -> bool:
    """True for a finite value in a field's range, or for its automatic one."""
    return value == field.auto or (
        math.isfinite(value)
        and (field.above is None or value > field.above)
        and (field.at_least is None or value >= field.at_least)
        and (field.below is None or value < field.below)
        and (field.at_most is None or value <= field.at_most)
    )


def allowed(field: Field, whole: bool = False) -> str:
    """What a parameter may be, in words: "a finite number above 0 [kg]"."""
    limits = (
        ("above", field.above),
        ("at least", field.at_least),
        ("below", field.below),
        ("at most", field.at_most),
    )
    bounds = " and ".join(f"{word} {limit:g}" for word, limit in limits if limit is not None)
    kind = "a whole number" if whole else "a finite number"
    automatic = 'or "auto"' if field.auto is not None else ""
    parts = (kind, bounds, f"[{field.unit}]" if field.unit else "", automatic)
    return " ".join(part for part in parts if part)
