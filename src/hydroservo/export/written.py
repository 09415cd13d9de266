"""The functions whose C is written, not translated: bits of numbers, random words, arithmetic on states."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from hydroservo import states
from hydroservo.export import parts
from hydroservo.export.names import identifier
from hydroservo.export.terms import BOOL, REAL, Function, Known, Matrix, Record, Type
from hydroservo.export.translate import Translator
from hydroservo.export.write import Writer
from hydroservo.ops import basic, binary, random

__all__ = ["WRITTEN"]

X = [("x", REAL)]


class Format(NamedTuple):
    """A floating-point format: what the functions below need to know of it."""

    real: str
    bits: str
    mantissa: int  # bits behind the point
    one: str  # the bits of 1
    least_mantissa: str  # the bits of the largest number below sqrt(1/2), plus one
    bias: int
    rounder: str  # 1.5 2^mantissa + 2 bias: leaves n + 2 bias in the lowest bits of n + rounder
    whole: str  # 2^mantissa: from here on every number is whole
    suffix: str


DOUBLE = Format(
    "double",
    "uint64_t",
    52,
    "UINT64_C(0x3FF0000000000000)",
    "UINT64_C(0x3FE6A09E667F3BCD)",
    1023,
    "6755399441057790.0",
    "4503599627370496.0",
    "",
)
SINGLE = Format(
    "float",
    "uint32_t",
    23,
    "UINT32_C(0x3F800000)",
    "UINT32_C(0x3F3504F3)",
    127,
    "12583166.0f",
    "8388608.0f",
    "f",
)


def form(writer: Writer) -> Format:
    return SINGLE if writer.real == "float" else DOUBLE


def library(name: str, returns: Type = REAL, parameters: Sequence[str] = ("x",)) -> Callable[..., Function]:
    """A function of math.h that every compiler turns into instructions."""
    return lambda *_: Function(name, [(one, REAL) for one in parameters], returns=returns)


def plain(name: str, text: Callable[[Writer], str], **more: Any) -> Callable[..., Function]:
    """A function of one number."""
    return lambda *_: Function(name, list(X), written=text, **more)


def bits_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* The bits of a number. */
static {f.bits} ops_bits({f.real} x) {{
    union {{ {f.real} number; {f.bits} bits; }} both;
    both.number = x;
    return both.bits;
}}
"""


def number_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* The number that has these bits. */
static {f.real} ops_number({f.bits} x) {{
    union {{ {f.bits} bits; {f.real} number; }} both;
    both.bits = x;
    return both.number;
}}
"""


BITS = Function("ops_bits", list(X), written=bits_text)
NUMBER = Function("ops_number", list(X), written=number_text)


def exponent_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* The whole number e for which x = 2^e m with m in [sqrt(1/2), sqrt(2)); for normal x > 0. */
static {f.real} ops_exponent({f.real} x) {{
    const {f.bits} moved = ops_bits(x) + ({f.one} - {f.least_mantissa});
    const int32_t e = (int32_t)(moved >> {f.mantissa}) - {f.bias};
    return ({f.real})e;
}}
"""


def mantissa_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* The m in [sqrt(1/2), sqrt(2)) for which x = 2^e m; for normal x > 0. */
static {f.real} ops_mantissa({f.real} x) {{
    const {f.bits} moved = ops_bits(x) + ({f.one} - {f.least_mantissa});
    return ops_number((ops_bits(x) + {f.one}) - ((moved >> {f.mantissa}) << {f.mantissa}));
}}
"""


def scaled_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* x 2^n, rounded once: two factors of half the exponent each, of which the last alone can round. */
static {f.real} ops_scaled({f.real} x, {f.real} n) {{
    const {f.bits} biased = ops_bits(n + {f.rounder});
    const {f.bits} half = biased >> 1;
    return (x * ops_number(half << {f.mantissa})) * ops_number((biased - half) << {f.mantissa});
}}
"""


def sqrt_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* Square root; nan below zero. */
static {f.real} ops_sqrt({f.real} x) {{
    return (x >= 0.0{f.suffix}) ? sqrt{f.suffix}(x) : {writer.number(math.nan)[0]};
}}
"""


def floor_text(writer: Writer) -> str:
    f = form(writer)
    return f"""\
/* Largest whole number not above x; C's own is a call on many processors. */
static {f.real} ops_floor({f.real} x) {{
    const {f.real} size = fabs{f.suffix}(x);
    const {f.real} whole = copysign{f.suffix}((size + {f.whole}) - {f.whole}, x);
    const {f.real} below = (whole > x) ? (whole - 1.0{f.suffix}) : whole;
    return (size < {f.whole}) ? below : x;
}}
"""


def isnan_text(writer: Writer) -> str:
    return f"""\
/* True for not-a-number. */
static bool ops_isnan({writer.real} x) {{
    return isnan(x) != 0;
}}
"""


def isfinite_text(writer: Writer) -> str:
    return f"""\
/* True unless infinite or not-a-number. */
static bool ops_isfinite({writer.real} x) {{
    return isfinite(x) != 0;
}}
"""


WHOLE_TEXT = """\
/* A whole number from 0 to 2^64 as one; 0 for all that is none. */
static uint64_t ops_whole(double x) {
    return ((x >= 0.0) && (x < 18446744073709551616.0)) ? (uint64_t)x : 0U;
}
"""
WHOLE = Function("ops_whole", list(X), written=lambda _: WHOLE_TEXT)

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


def drawn(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``ops.random.drawn`` for one kind of numbers."""
    *numbers, kind = arguments
    assert isinstance(kind, Known)
    pair = translator.record(None, {"first": REAL, "second": REAL}, "pair")
    name = translator.function_name("ops_drawn")

    def text(writer: Writer) -> str:
        return DRAWN.format(
            pair=writer.type(pair),
            name=name,
            kind=kind.value,
            rounds=random.ROUNDS,
            first=random.MULTIPLIERS[0],
            second=random.MULTIPLIERS[1],
            key=random.KEY_STEPS[0],
            other_key=random.KEY_STEPS[1],
            scale=2.0**-53,
        )

    parameters = list(zip(("seed", "stream", "at"), numbers, strict=True))
    return Function(name, parameters, returns=pair, written=text, calls=(WHOLE,), whole=(pair,))


def axpy(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.axpy`` for records of one type."""
    record = arguments[0]
    assert isinstance(record, Record)
    name = translator.function_name(f"axpy_{record.name}")

    def text(writer: Writer) -> str:
        return numbers_text(writer, record, name, "x + h k", ("x", "h", "k"), "x->{0} + (h * k->{0})")

    return Function(name, [("x", record), ("h", REAL), ("k", record)], returns=record, written=text)


def scaled(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.scaled`` for records of one type."""
    record = arguments[1]
    assert isinstance(record, Record)
    name = translator.function_name(f"scaled_{record.name}")

    def text(writer: Writer) -> str:
        return numbers_text(writer, record, name, "h k", ("h", "k"), "h * k->{0}")

    return Function(name, [("h", REAL), ("k", record)], returns=record, written=text)


def numbers_text(
    writer: Writer, record: Record, name: str, what: str, names: Sequence[str], number: str
) -> str:
    """A function that makes a record, each number by the same expression of others."""
    kind = writer.type(record)
    given = ", ".join(f"{writer.real} h" if one == "h" else f"const {kind} *{one}" for one in names)
    lines = [f"    result.{place} = {number.format(place)};" for place in writer.leaves(record)]
    head = f"static {kind} {name}({given}) {{"
    return "\n".join([f"/* {what}, number by number. */", head, f"    {kind} result;", *lines, *END, ""])


END = ["    return result;", "}"]


def misses(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.misses`` for records of one type."""
    record = arguments[0]
    assert isinstance(record, Record)
    miss = translator.function(states.miss, [REAL] * 5)
    inner = [
        translator.function(states.misses, [kind] * 4 + [REAL])
        for kind in record.fields.values()
        if has_numbers(kind)
    ]
    name = translator.function_name(f"misses_{record.name}")
    names = ("error", "x", "y", "rate")

    def text(writer: Writer) -> str:
        pending = iter(inner)
        lines = []
        for field, kind in record.fields.items():
            if writer.needed.has(record, field):
                callee, mark = (next(pending), "&") if isinstance(kind, Record) else (miss, "")
                given = ", ".join(f"{mark}{one}->{identifier(field)}" for one in names)
                lines.append(f"    total = total + {callee.name}({given}, dt);")
        given = ", ".join(f"const {writer.type(record)} *{one}" for one in names)
        head = ["/* The sum of the squares of a step's relative errors. */"]
        head += [f"static double {name}({given}, double dt) {{", "    double total = 0.0;"]
        return "\n".join([*head, *lines, "    return total;", "}", ""])

    parameters: list[tuple[str, Type]] = [*((one, record) for one in names), ("dt", REAL)]
    return Function(name, parameters, written=text, calls=(miss, *inner), whole=(record,))


FACTORED = """\
/* The matrix 1/h - J from forward differences, split into triangles; its diagonal holds reciprocals. */
static {matrix} {name}({given}) {{
    {matrix} result;
    double (*const a)[{n}] = result.a;
    {state} nudged = *x;
    double number[{n}];
    double rate[{n}];
    double moved[{n}];
    {unpack_x}
    {unpack_f}
    for (int32_t j = 0; j < {n}; j++) {{
        const double kept = number[j];
        const double change = {nudge}(kept, rate[j], h);
        number[j] = kept + change;
        {pack_nudged}
        const {state} rates = {deriv};
        {unpack_rates}
        number[j] = kept;
        for (int32_t i = 0; i < {n}; i++) {{
            a[i][j] = ((i == j) ? (1.0 / h) : 0.0) - ((moved[i] - rate[i]) / change);
        }}
    }}
    for (int32_t k = 0; k < {n}; k++) {{
        a[k][k] = 1.0 / a[k][k];
        for (int32_t i = k + 1; i < {n}; i++) {{
            a[i][k] = a[i][k] * a[k][k];
            for (int32_t j = k + 1; j < {n}; j++) {{
                a[i][j] = a[i][j] - (a[i][k] * a[k][j]);
            }}
        }}
    }}
    return result;
}}
"""


def factored(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.factored`` for a system and records of one type."""
    system, t, x, u, *_ = arguments
    assert isinstance(system, Record)
    assert isinstance(x, Record)
    size = sum(1 for _ in leaf_places(x))
    nudge = translator.function(states.nudge, [REAL] * 3)
    deriv = translator.method(system, "deriv", [t, x, u])
    name = translator.function_name(f"factored_{x.name}")
    matrix = Matrix(size)
    parameters = list(zip(("system", "t", "x", "u", "f", "h"), arguments, strict=True))

    def text(writer: Writer) -> str:
        places = list(leaf_places(x))
        needed = {one for one, _ in writer.needed.takes(deriv)}
        own = dict(zip([one for one, _ in deriv.parameters], ("system", "t", "&nudged", "u"), strict=True))
        call = f"{deriv.name}({', '.join(text for one, text in own.items() if one in needed)})"
        taken = writer.needed.takes(made)
        return FACTORED.format(
            matrix=writer.type(matrix),
            name=name,
            given=writer.signature(taken),
            n=size,
            state=writer.type(x),
            nudge=nudge.name,
            deriv=call,
            unpack_x=joined(f"number[{i}] = x->{place};" for i, place in enumerate(places)),
            unpack_f=joined(f"rate[{i}] = f->{place};" for i, place in enumerate(places)),
            pack_nudged=joined((f"nudged.{place} = number[{i}];" for i, place in enumerate(places)), 8),
            unpack_rates=joined((f"moved[{i}] = rates.{place};" for i, place in enumerate(places)), 8),
        )

    made = Function(name, parameters, returns=matrix, written=text, calls=(nudge, deriv), whole=(x,))
    return made


def infinite(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``parts.infinite`` for records of one type."""
    (record,) = arguments
    assert isinstance(record, Record)
    name = translator.function_name(f"infinite_{record.name}")

    def text(writer: Writer) -> str:
        checks = [f"(isinf(s->{place}) != 0)" for place in writer.leaves(record)]
        head = f"static bool {name}(const {writer.type(record)} *s) {{"
        said = "/* True if any number is infinite. */"
        return "\n".join([said, head, f"    return {joined(checks, 8, ' ||')};", "}", ""])

    return Function(name, [("s", record)], returns=BOOL, written=text, whole=(record,))


def joined(lines: Iterable[str], depth: int = 4, between: str = "") -> str:
    return f"{between}\n{' ' * depth}".join(lines)


def has_numbers(kind: Type) -> bool:
    """True for a record with at least one number."""
    return isinstance(kind, Record) and any(leaf_places(kind))


def leaf_places(record: Record, place: str = "") -> Iterator[str]:
    """The place of each number of a record, whether it is needed or not."""
    for name, kind in record.fields.items():
        if isinstance(kind, Record):
            yield from leaf_places(kind, f"{place}{identifier(name)}.")
        else:
            yield place + identifier(name)


SOLVED = """\
/* The solution z of (1/h - J) z = k. */
static {state} {name}(const {matrix} *matrix, const {state} *k) {{
    {state} result;
    double z[{n}];
    {unpack}
    for (int32_t i = 0; i < {n}; i++) {{
        for (int32_t j = 0; j < i; j++) {{
            z[i] = z[i] - (matrix->a[i][j] * z[j]);
        }}
    }}
    for (int32_t i = {n} - 1; i >= 0; i--) {{
        for (int32_t j = i + 1; j < {n}; j++) {{
            z[i] = z[i] - (matrix->a[i][j] * z[j]);
        }}
        z[i] = z[i] * matrix->a[i][i];
    }}
    {pack}
    return result;
}}
"""


def solved(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.solved`` for records of one type."""
    matrix, record = arguments
    assert isinstance(record, Record)
    name = translator.function_name(f"solved_{record.name}")

    def text(writer: Writer) -> str:
        places = list(leaf_places(record))
        return SOLVED.format(
            matrix=writer.type(matrix),
            state=writer.type(record),
            name=name,
            n=len(places),
            unpack=joined(f"z[{i}] = k->{place};" for i, place in enumerate(places)),
            pack=joined(f"result.{place} = z[{i}];" for i, place in enumerate(places)),
        )

    parameters = [("matrix", matrix), ("k", record)]
    return Function(name, parameters, returns=record, written=text, whole=(record,))


def needs_bits(
    name: str, text: Callable[[Writer], str], parameters: Sequence[str] = ("x",)
) -> Callable[..., Function]:
    """A function of the bits of a number."""
    return lambda *_: Function(name, [(one, REAL) for one in parameters], written=text, calls=(BITS, NUMBER))


WRITTEN: dict[Any, Callable[[Translator, Sequence[Type]], Function]] = {
    basic.absolute: library("fabs"),
    basic.copysign: library("copysign", parameters=("x", "y")),
    basic.isnan: plain("ops_isnan", isnan_text, returns=BOOL),
    basic.isfinite: plain("ops_isfinite", isfinite_text, returns=BOOL),
    basic.sqrt: plain("ops_sqrt", sqrt_text),
    basic.floor: plain("ops_floor", floor_text),
    binary.exponent: lambda *_: Function("ops_exponent", list(X), written=exponent_text, calls=(BITS,)),
    binary.mantissa: needs_bits("ops_mantissa", mantissa_text),
    binary.scaled: needs_bits("ops_scaled", scaled_text, ("x", "n")),
    random.drawn: drawn,
    states.axpy: axpy,
    states.scaled: scaled,
    states.misses: misses,
    states.factored: factored,
    states.solved: solved,
    parts.infinite: infinite,
}
