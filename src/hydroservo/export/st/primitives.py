"""What Structured Text gives otherwise than an operator, and what it takes in place of bits of numbers."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import FunctionType, MappingProxyType
from typing import Any, NamedTuple

from hydroservo.core.ops import basic, binary, portable, random
from hydroservo.engine import state_text
from hydroservo.export import parts
from hydroservo.export.c.primitives import always, numbers
from hydroservo.export.st.names import BEYOND
from hydroservo.export.st.pou import Declaration, Pou
from hydroservo.language import functions
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import REAL, Function, Record, Translator, Type

PORTABLE: dict[Any, Any] = {
    basic.absolute: portable.absolute,
    basic.copysign: portable.copysign,
    basic.floor: portable.floor,
    binary.exponent: portable.exponent,
    binary.mantissa: portable.mantissa,
    binary.scaled: portable.scaled,
    math.fmod: portable.remainder,
}


def translate_by_text(function: Any) -> Callable[[Translator, Sequence[Type]], Function]:
    """What translates a function of numbers by its own text."""
    return lambda translator, arguments: translator.function(function, [REAL] * len(arguments))


def infinite_text(shape: Record) -> FunctionType:
    """``parts.infinite`` for states of one type, without an infinite number to compare with."""
    return parts.infinite_text(shape, "is_infinite({})", is_infinite=portable.is_infinite)


def refuse_random(*_: object) -> Function:
    """Random numbers take whole numbers without a sign, which wrap round."""
    raise TranslationError("random numbers have no Structured Text")


WRITTEN: dict[Any, Callable[[Translator, Sequence[Type]], Function]] = {
    **{origin: translate_by_text(function) for origin, function in PORTABLE.items()},
    **state_text.TRANSLATED,
    parts.infinite: state_text.for_records(infinite_text, 0),
    random.drawn: refuse_random,
    basic.sqrt: always(numbers.SQRT),
    functions.whole_modulo: always(numbers.MODULO),
    functions.whole_quotient: always(numbers.QUOTIENT),
}


class Text(NamedTuple):
    """A function whose text is written, not translated."""

    about: str  # what it gives
    body: str  # its statements, with ``{f}`` for its name, ``{p}`` for the prefix, ``{real}`` for numbers
    inputs: Mapping[str, str] = MappingProxyType({"x": "{real}"})  # name and type of each argument
    kind: str = "{real}"  # of its value
    variables: Mapping[str, str] = MappingProxyType({})  # name and type of each
    calls: Sequence[str] = ()  # other such functions


NO_ARGUMENT = "unused"  # some compilers refuse functions without inputs
PAIR = {"a": "LINT", "b": "LINT"}
TEXTS = {
    "number": Text(
        "The number mantissa * 2^exponent, which is infinite for exponents that no number has.",
        """\
value := mantissa;
left_over := exponent;
WHILE left_over >= 32.0 DO
    value := value * 4294967296.0;
    left_over := left_over - 32.0;
END_WHILE;
WHILE left_over <= -32.0 DO
    value := value * 2.3283064365386963E-10;
    left_over := left_over + 32.0;
END_WHILE;
WHILE left_over > 0.0 DO
    value := value * 2.0;
    left_over := left_over - 1.0;
END_WHILE;
WHILE left_over < 0.0 DO
    value := value * 0.5;
    left_over := left_over + 1.0;
END_WHILE;
{f} := value;""",
        {"mantissa": "{real}", "exponent": "{real}"},
        variables={"value": "{real}", "left_over": "{real}"},
    ),
    "nan": Text(
        "Not a number.",
        "{f} := {p}_number(1.0, {beyond}.0) - {p}_number(1.0, {beyond}.0);",
        {NO_ARGUMENT: "BOOL"},
        calls=["number"],
    ),
    "ops_sqrt": Text(
        "Square root; not-a-number below zero.",
        "IF x >= 0.0 THEN\n    {f} := SQRT(x);\nELSE\n    {f} := {p}_nan(FALSE);\nEND_IF;",
        calls=["nan"],
    ),
    "ops_quotient": Text(
        "The largest whole number not above a/b, for b > 0.",
        "IF a MOD b < 0 THEN\n    {f} := a / b - 1;\nELSE\n    {f} := a / b;\nEND_IF;",
        PAIR,
        "LINT",
    ),
    "ops_modulo": Text(
        "a - b floor(a/b), for b > 0.",
        "IF a MOD b < 0 THEN\n    {f} := a MOD b + b;\nELSE\n    {f} := a MOD b;\nEND_IF;",
        PAIR,
        "LINT",
    ),
    "truncated": Text(
        "A number without what is behind its point; conversions round.",
        """\
near := {real}_TO_LINT(x);
IF (x > 0.0) AND (LINT_TO_{real}(near) > x) THEN
    near := near - 1;
ELSIF (x < 0.0) AND (LINT_TO_{real}(near) < x) THEN
    near := near + 1;
END_IF;
{f} := near;""",
        kind="LINT",
        variables={"near": "LINT"},
    ),
}


def text_function(name: str, prefix: str, real: str) -> Pou:
    """A function whose text is written, for numbers of one type."""
    it = TEXTS[name]
    known = {"p": prefix, "f": f"{prefix}_{name}", "real": real, "beyond": str(BEYOND)}
    sections = {
        head: [Declaration(own, kind.format(**known)) for own, kind in declared.items()]
        for head, declared in (("VAR_INPUT", it.inputs), ("VAR", it.variables))
    }
    body = it.body.format(**known).split("\n")
    return Pou(known["f"], it.kind.format(**known), it.about, sections, body)


def with_callees(names: Iterable[str]) -> list[str]:
    """Names of such functions and of all that they call, each after those."""
    order: dict[str, None] = {}
    for name in names:
        order |= dict.fromkeys([*with_callees(TEXTS[name].calls), name])
    return list(order)
