"""Functions of whole states: the test for infinite numbers, linear systems, random numbers."""

from collections.abc import Iterator, Sequence

from hydroservo.core import states
from hydroservo.core.ops import random
from hydroservo.engine.state_text import record_of
from hydroservo.export.c.writer import CWriter
from hydroservo.language.names import identifier
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import BOOL, REAL, Function, Known, Matrix, Record, Translator, Type

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


def known_of(kind: Type) -> int:
    """A whole number that is part of the code."""
    if not (isinstance(kind, Known) and isinstance(kind.value, int)):
        raise TranslationError("the kind of a random number is part of the code, not a signal")
    return kind.value


def leaf_places(record: Record, place: str = "") -> Iterator[str]:
    """The place of each number of a record, whether it is needed or not."""
    for name, kind in record.fields.items():
        if isinstance(kind, Record):
            yield from leaf_places(kind, f"{place}{identifier(name)}.")
        else:
            yield place + identifier(name)


def infinite(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``parts.infinite`` for records of one type."""
    (state,) = arguments
    record = record_of(state)
    parameters: list[tuple[str, Type]] = [("s", record)]
    name = translator.function_name("infinite")

    def text(writer: CWriter) -> str:
        size, infinity = ("fabsf", "INFINITY") if writer.real == "float" else ("fabs", "(double)INFINITY")
        tests = [f"({size}(s->{place}) == {infinity})" for place in writer.leaves(record)]
        lines = [
            "/* True if any number is infinite. */",
            f"static bool {name}({writer.signature(parameters)}) {{",
            f"    return {' || '.join(tests)};",
            "}",
            "",
        ]
        return "\n".join(lines)

    return Function(name, parameters, returns=BOOL, written=text, whole=(record,))


def factored(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.factored`` for a system and records of one type."""
    system, t, x, u, *_ = arguments
    state = record_of(x)
    places = list(leaf_places(state))
    nudge = translator.function(states.nudge, [REAL] * 3)
    deriv = translator.method(record_of(system), "deriv", [t, x, u])
    name = translator.function_name(f"factored_{state.name}")
    matrix = Matrix(len(places))
    parameters = list(zip(("system", "t", "x", "u", "f", "h"), arguments, strict=True))

    def text(writer: CWriter) -> str:
        needed = {one for one, _ in writer.needed.takes(deriv)}
        own = dict(zip([one for one, _ in deriv.parameters], ("system", "t", "&nudged", "u"), strict=True))
        call = f"{deriv.name}({', '.join(text for one, text in own.items() if one in needed)})"
        taken = writer.needed.takes(made)
        return FACTORED.format(
            matrix=writer.type(matrix),
            name=name,
            given=writer.signature(taken),
            n=len(places),
            state=writer.type(state),
            nudge=nudge.name,
            deriv=call,
            unpack_x="\n".join(f"number[{i}] = x->{place};" for i, place in enumerate(places)),
            unpack_f="\n".join(f"rate[{i}] = f->{place};" for i, place in enumerate(places)),
            pack_nudged="\n".join(f"nudged.{place} = number[{i}];" for i, place in enumerate(places)),
            unpack_rates="\n".join(f"moved[{i}] = rates.{place};" for i, place in enumerate(places)),
        )

    made = Function(name, parameters, returns=matrix, written=text, calls=(nudge, deriv), whole=(state,))
    return made


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
    matrix, k = arguments
    record = record_of(k)
    places = list(leaf_places(record))
    name = translator.function_name(f"solved_{record.name}")

    def text(writer: CWriter) -> str:
        return SOLVED.format(
            matrix=writer.type(matrix),
            state=writer.type(record),
            name=name,
            n=len(places),
            unpack="\n".join(f"z[{i}] = k->{place};" for i, place in enumerate(places)),
            pack="\n".join(f"result.{place} = z[{i}];" for i, place in enumerate(places)),
        )

    parameters = [("matrix", matrix), ("k", record)]
    return Function(name, parameters, returns=record, written=text, whole=(record,))


def drawn(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``ops.random.drawn`` for one kind of numbers."""
    *numbers, last = arguments
    kind = known_of(last)
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
