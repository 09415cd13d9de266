"""Linear systems of equations, as in ``states``: split into triangles once, then solved."""

from collections.abc import Sequence

from hydroservo import states
from hydroservo.engine.state_text import record_of
from hydroservo.export.c.primitives.kinds import leaf_places
from hydroservo.export.c.writer import Writer
from hydroservo.language.terms import REAL, Function, Matrix, Translator, Type

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
    state = record_of(x)
    places = list(leaf_places(state))
    nudge = translator.function(states.nudge, [REAL] * 3)
    deriv = translator.method(record_of(system), "deriv", [t, x, u])
    name = translator.function_name(f"factored_{state.name}")
    matrix = Matrix(len(places))
    parameters = list(zip(("system", "t", "x", "u", "f", "h"), arguments, strict=True))

    def text(writer: Writer) -> str:
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

    def text(writer: Writer) -> str:
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
