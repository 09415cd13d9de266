"""Calls: of methods and functions, which are lowered in their place, of classes, and of what Python has."""

import ast
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any

from hydroservo import block, states
from hydroservo.engine import state_text
from hydroservo.engine.lower.expressions import spread
from hydroservo.engine.lower.frame import Frame, inlined, lowers
from hydroservo.engine.lower.instructions import INSTRUCTIONS
from hydroservo.engine.lower.loops import Range
from hydroservo.engine.lower.source import hint_for
from hydroservo.engine.lower.values import (
    PYTHON_TYPES,
    Array,
    Bound,
    Composite,
    LoweringError,
    Record,
    Scalar,
    is_number,
    lifted,
)
from hydroservo.engine.lower.writer import said
from hydroservo.engine.state_text import Shape


@lowers(ast.Call)
def call(frame: Frame, node: ast.Call) -> Any:
    frame.line = node.lineno
    called = frame.value(node.func)
    if not is_known(called):
        raise LoweringError(f"compiled code does not support {ast.unparse(node)}", hint_for(called))
    given = spread(frame, node.args)
    named = {str(one.arg): frame.value(one.value) for one in node.keywords if one.arg}
    if len(named) < len(node.keywords):
        raise LoweringError(f"compiled code cannot unpack {ast.unparse(node)}")
    frame.line = node.lineno
    if isinstance(called, Bound):
        return inlined(frame.writer, called.function, [called.owner, *given], named, frame.stack)
    try:
        found = replaced(frame, called, given, named)
    except TypeError:
        raise LoweringError(
            f"compiled code does not support {ast.unparse(node)} with such arguments", hint_for(called)
        ) from None
    if isinstance(found, FunctionType):
        return inlined(frame.writer, found, given, named, frame.stack)
    return found


def is_known(called: Any) -> bool:
    """Whether compiled code can call it."""
    if isinstance(called, Bound | FunctionType):
        return True
    try:
        return called in INSTRUCTIONS or called in PYTHON or hasattr(called, "_fields")
    except TypeError:
        return False


def replaced(frame: Frame, called: Any, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
    """What a call returns, or the function whose text is to be lowered for it."""
    if called in PYTHON:
        return PYTHON[called](*given)
    if called in INSTRUCTIONS:
        known = computed(called, given) if not named else None
        return INSTRUCTIONS[called](frame.writer, *given, **named) if known is None else known
    if called in STATES:
        return STATES[called](*given, **named)
    return called if isinstance(called, FunctionType) else record(called, given, named)


def computed(called: Callable[..., Any], given: Sequence[Any]) -> Any:
    """What a function gives for numbers that are known; None where they are not, or it gives none."""
    if not given or any(isinstance(value, Scalar) or not is_number(value) for value in given):
        return None
    try:
        return lifted(called(*given))
    except (ArithmeticError, ValueError):
        return None


def record(cls: Any, given: Sequence[Any], named: Mapping[str, Any]) -> Record:
    """A block of a class."""
    fields = cls._fields
    values = dict(zip(fields, given, strict=False)) | dict(named)
    spare = cls._field_defaults
    unknown = [name for name in named if name not in fields or fields.index(name) < len(given)]
    lacking = [name for name in fields if name not in values and name not in spare]
    if len(given) > len(fields) or unknown or lacking:
        problem = f"lacks {lacking[0]}" if lacking else f"takes {', '.join(fields)} alone"
        raise LoweringError(f"{cls.__name__} {problem}")
    return Record(cls, [values[name] if name in values else lifted(spare[name]) for name in fields])


def length(value: Any) -> Any:
    if isinstance(value, Array):
        return value.lengths[0]
    return len(parts(value))


def parts(value: Any) -> tuple[Any, ...]:
    """What a tuple holds."""
    if not isinstance(value, Record):
        raise LoweringError(f"{said(value)} is not a tuple")
    return value.parts


def range_(*given: Any) -> Range:
    start, stop, step = (0, *given, 1) if len(given) == 1 else (*given, 1)[:3]
    return Range(start, stop, step)


def is_instance(value: Any, kinds: Any) -> bool:
    """Whether a value is of one of some classes."""
    wanted = kinds.parts if isinstance(kinds, Record) else (kinds,)
    if isinstance(value, Record):
        return issubclass(value.cls, wanted)
    if isinstance(value, Composite | Bound):
        return False
    if isinstance(value, Scalar) and is_number(value):
        return issubclass(PYTHON_TYPES[value.kind], wanted)
    return isinstance(value, wanted)


def has(value: Any, name: Any) -> bool:
    """Whether a block has a field or a method of that name."""
    return hasattr(value.cls, name) if isinstance(value, Record) else hasattr(value, name)


PYTHON: dict[Any, Callable[..., Any]] = {
    enumerate: lambda value: Record(tuple, [Record(tuple, pair) for pair in enumerate(parts(value))]),
    hasattr: has,
    isinstance: is_instance,
    len: length,
    range: range_,
    reversed: lambda value: Record(tuple, parts(value)[::-1]),
    tuple: lambda value: Record(tuple, parts(value)),
    zip: lambda *rows: Record(tuple, [Record(tuple, row) for row in zip(*map(parts, rows), strict=False)]),
}


def shape_of(value: Any) -> Shape:
    """The shape of a state."""
    if not isinstance(value, Record) or not hasattr(value.cls, "_fields"):
        raise LoweringError(f"{said(value)} is not a state")
    parts = zip(value.cls._fields, value.parts, strict=True)
    return Shape(
        value.cls, {name: shape_of(part) if isinstance(part, Record) else None for name, part in parts}
    )


STATES: dict[Any, Callable[..., FunctionType]] = {  # by their own arguments
    states.axpy: lambda x, _h, _k: state_text.axpy(shape_of(x)),
    states.scaled: lambda _h, k: state_text.scaled(shape_of(k)),
    states.misses: lambda error, *_: state_text.misses(shape_of(error)),
    states.factored: lambda _system, _t, x, *_: state_text.factored(shape_of(x)),
    states.solved: lambda _matrix, k: state_text.solved(shape_of(k)),
    states.overlaid: lambda x, given: state_text.overlaid(shape_of(x), shape_of(given)),
    block.estimates_in: lambda state: state_text.estimates_in(shape_of(state)),
    block.model_in: lambda controller: state_text.model_in(shape_of(controller)),
}
