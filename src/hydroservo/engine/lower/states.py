"""The arithmetic on whole states, written out for the types that a call is given."""

from collections.abc import Callable
from types import FunctionType
from typing import Any

from hydroservo import block, states
from hydroservo.engine import state_text
from hydroservo.engine.lower.values import LoweringError, Record
from hydroservo.engine.lower.writer import said
from hydroservo.engine.state_text import Shape


def shape_of(value: Any) -> Shape:
    """The shape of a state.

    Raises:
        LoweringError: it is none.
    """
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
