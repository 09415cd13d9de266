"""The functions that are no plain text of Python: bits of numbers, random words, arithmetic on states."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo import states
from hydroservo.engine import state_text
from hydroservo.export import parts
from hydroservo.export.c.primitives import bits, floats, linear, wholes
from hydroservo.export.c.primitives.infinite import infinite
from hydroservo.export.c.primitives.random import drawn
from hydroservo.language import remainders
from hydroservo.language.terms import Function, Translator, Type
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
    math.fmod: floats.FMOD,
    remainders.whole_modulo: wholes.MODULO,
    remainders.whole_quotient: wholes.QUOTIENT,
    binary.exponent: bits.EXPONENT,
    binary.mantissa: bits.MANTISSA,
    binary.scaled: bits.SCALED_NUMBER,
}
MADE = {
    random.drawn: drawn,
    **state_text.TRANSLATED,
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
