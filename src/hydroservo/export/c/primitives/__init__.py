"""The functions that are no plain text of Python: bits of numbers, random words, arithmetic on states."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.core.ops import basic, binary, random
from hydroservo.engine import state_text
from hydroservo.export import parts
from hydroservo.export.c.primitives import numbers
from hydroservo.export.c.primitives.states import drawn_in_c
from hydroservo.language import functions
from hydroservo.language.terms import Function, Translator, Type

# What a Python function becomes: the same for all arguments, or made for their types.
NUMBERS = {
    basic.absolute: numbers.ABSOLUTE,
    basic.copysign: numbers.COPYSIGN,
    basic.floor: numbers.FLOOR,
    basic.isfinite: numbers.ISFINITE,
    basic.isnan: numbers.ISNAN,
    basic.sqrt: numbers.SQRT,
    math.fmod: numbers.FMOD,
    functions.whole_modulo: numbers.MODULO,
    functions.whole_quotient: numbers.QUOTIENT,
    binary.exponent: numbers.EXPONENT,
    binary.mantissa: numbers.MANTISSA,
    binary.scaled: numbers.SCALED_NUMBER,
}
MADE = {
    random.drawn: drawn_in_c,
    **state_text.TRANSLATED,
    parts.infinite: state_text.for_records(parts.infinite_text, 0),
}


def always(function: Function) -> Callable[[Translator, Sequence[Type]], Function]:
    return lambda _, __: function


WRITTEN: dict[Any, Callable[[Translator, Sequence[Type]], Function]] = {
    **{origin: always(function) for origin, function in NUMBERS.items()},
    **MADE,
}
