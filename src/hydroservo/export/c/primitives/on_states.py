"""Arithmetic on whole states, translated from the texts that the engine compiles."""

from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

from hydroservo.engine import state_text
from hydroservo.engine.state_text import Shape
from hydroservo.export.c.primitives.kinds import record_of
from hydroservo.export.translate.body import Body
from hydroservo.export.translate.terms import Function, Record, Translator, Type

Made = Callable[[Translator, Sequence[Type]], Function]


def for_states(text: Callable[[Shape], FunctionType], number: int) -> Made:
    """What translates a function by the text for states of the type of argument ``number``."""

    def made(translator: Translator, arguments: Sequence[Type]) -> Function:
        shape = shape_of(record_of(arguments[number]))
        return Body(translator, text(shape), arguments, None).translated()

    return made


def overlaid(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.overlaid`` from its text for a state and a group of these types."""
    state, given = (shape_of(record_of(argument)) for argument in arguments)
    return Body(translator, state_text.overlaid(state, given), arguments, None).translated()


def own_text(origin: Any) -> Made:
    """What translates a function from its own text."""
    return lambda translator, arguments: Body(translator, origin, arguments, None).translated()


def shape_of(record: Record) -> Shape:
    """The shape of a state's type."""
    fields = record.fields.items()
    return Shape(
        record.cls or tuple,
        {name: shape_of(kind) if isinstance(kind, Record) else None for name, kind in fields},
    )


axpy = for_states(state_text.axpy, 0)
scaled = for_states(state_text.scaled, 1)
misses = for_states(state_text.misses, 0)
