"""The functions that are no plain text of Python: bits of numbers, random words, arithmetic on states."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from hydroservo.core.ops import basic, binary, random
from hydroservo.engine import state_text
from hydroservo.export import parts
from hydroservo.export.c.primitives import numbers
from hydroservo.export.c.writer import CWriter
from hydroservo.language import functions
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import REAL, Function, Known, Translator, Type

WHOLE_TEXT = """\
/* A whole number from 0 to 2^64 as one; 0 for all that is none. */
static uint64_t ops_whole(double x) {
    return ((x >= 0.0) && (x < 18446744073709551616.0)) ? (uint64_t)x : 0U;
}
"""
WHOLE = Function("ops_whole", [("x", REAL)], written=lambda _: WHOLE_TEXT)

DRAWN = """\
/* Two numbers drawn evenly from [0, 1), from the four words of one draw: Philox4x32-10. */
static {pair} {name}(double seed, double stream, double at) {{
    const uint64_t sample = ops_whole(at);
    const uint64_t run = ops_whole(seed);
    uint32_t a = (uint32_t)sample;
    uint32_t b = (uint32_t)(sample >> 32);
    uint32_t c = (uint32_t)ops_whole(stream);
    uint32_t d = {kind}U;
    uint32_t k = (uint32_t)run;
    uint32_t q = (uint32_t)(run >> 32);
    for (int32_t i = 0; i < {rounds}; i++) {{
        const uint64_t first = (uint64_t){first}U * a;
        const uint64_t second = (uint64_t){second}U * c;
        a = ((uint32_t)(second >> 32) ^ b) ^ k;
        b = (uint32_t)second;
        c = ((uint32_t)(first >> 32) ^ d) ^ q;
        d = (uint32_t)first;
        k += {key}U;
        q += {other_key}U;
    }}
    return ({pair}){{
        .first = (((double)(a >> 5) * 67108864.0) + (double)(b >> 6)) * {scale!r},
        .second = (((double)(c >> 5) * 67108864.0) + (double)(d >> 6)) * {scale!r},
    }};
}}
"""


def drawn_in_c(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``ops.random.drawn`` for one kind of numbers."""
    *numbers, last = arguments
    if not (isinstance(last, Known) and isinstance(last.value, int)):
        raise TranslationError("the kind of a random number is part of the code, not a signal")
    kind = last.value
    pair = translator.record(None, {"first": REAL, "second": REAL}, "pair")
    name = translator.function_name("ops_drawn")

    def text(writer: CWriter) -> str:
        return DRAWN.format(
            pair=writer.type(pair),
            name=name,
            kind=kind,
            rounds=random.ROUNDS,
            first=random.MULTIPLIERS[0],
            second=random.MULTIPLIERS[1],
            key=random.KEY_STEPS[0],
            other_key=random.KEY_STEPS[1],
            scale=2.0**-53,
        )

    parameters = list(zip(("seed", "stream", "at"), numbers, strict=True))
    return Function(name, parameters, returns=pair, written=text, calls=(WHOLE,), whole=(pair,))


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
