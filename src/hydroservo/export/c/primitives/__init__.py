"""The functions that are no plain text of Python: bits of numbers, random words, arithmetic on states."""

from collections.abc import Callable, Sequence
from typing import Any

from hydroservo import states
from hydroservo.export import parts
from hydroservo.export.c.primitives import bits, floats, linear, on_states
from hydroservo.export.c.primitives.infinite import infinite
from hydroservo.export.c.primitives.random import drawn
from hydroservo.export.translate.terms import Function, Translator, Type
from hydroservo.ops import basic, binary, random

__all__ = ["WRITTEN"]

# What a Python function becomes: the same for all arguments, or made for their types.
NUMBERS = {
    basic.absolute: floats.ABSOLUTE,
    basic.copysign: floats.COPYSIGN,
    basic.floor: floats.FLOOR,
    basic.isfinite: floats.ISFINITE,
    basic.isnan: floats.ISNAN,
    basic.sqrt: floats.SQRT,
    binary.exponent: bits.EXPONENT,
    binary.mantissa: bits.MANTISSA,
    binary.scaled: bits.SCALED_NUMBER,
}
MADE = {
    random.drawn: drawn,
    states.axpy: on_states.axpy,
    states.scaled: on_states.scaled,
    states.misses: on_states.misses,
    states.miss: on_states.own_text(states.miss),
    states.overlaid: on_states.overlaid,
    states.nudge: on_states.own_text(states.nudge),
    states.factored: linear.factored,
    states.solved: linear.solved,
    parts.infinite: infinite,
}


def always(function: Function) -> Callable[[Translator, Sequence[Type]], Function]:
    return lambda _, __: function


WRITTEN: dict[Any, Callable[[Translator, Sequence[Type]], Function]] = {
    **{origin: always(function) for origin, function in NUMBERS.items()},
    **MADE,
}
