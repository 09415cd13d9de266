"""The header and the source of an exported unit."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from hydroservo.block import Block, declared_fields
from hydroservo.export.names import identifier
from hydroservo.export.needed import Needed
from hydroservo.export.terms import Function, Matrix, Record, Table
from hydroservo.export.wrap import comment, wrapped
from hydroservo.export.write import Ends, Writer

__all__ = ["Unit", "texts"]


class Unit(NamedTuple):
    """A translated unit.

    Attributes:
        block: its parameters.
        parameters: their record.
        init: makes the first state.
        step: makes the next one.
        arguments: name and record of what ``step`` is given besides the state.
        command: ``step`` returns the state's ``u``.
    """

    block: Block
    parameters: Record
    init: Function
    step: Function
    arguments: tuple[tuple[str, Record], ...]
    command: bool


class Texts(NamedTuple):
    """What goes into the two files."""

    header: str
    source: str


def texts(
    unit: Unit, needed: Needed, tables: Sequence[Table], prefix: str, about: str, real: str, inlined: bool
) -> Texts:
    """Header and source of a unit, with ``about`` as the comment on top of both."""
    writer = Writer(prefix, real, needed)
    public = [unit.init.returns, *(record for _, record in unit.arguments)]
    own = public if inlined else [unit.parameters, *public]
    shown: dict[Record, None] = {}
    for record in own:
        nested(record, needed, shown)
    functions = [writer.function(one) for one in needed.reached if one not in (unit.init, unit.step)]
    documented = with_classes([*needed.reached], functions, unit)
    entries = entry_texts(unit, writer, inlined)
    rest: dict[Record, None] = {}
    for record in used_records(unit, needed):
        nested(record, needed, rest)
    hidden = [writer.record(record) for record in rest if record not in shown]
    matrices = {one.returns for one in needed.reached if isinstance(one.returns, Matrix)}
    hidden += [matrix_text(writer, one) for one in matrices]
    defaults = defaults_text(unit, writer, inlined)
    constants = "".join(f"#define {name} {value}\n" for name, value in writer.constants.items())
    return Texts(
        header_text(
            prefix, about, [writer.record(one) for one in shown], declarations(unit, writer, inlined), inlined
        ),
        "\n".join(
            part
            for part in (
                comment(about),
                PREAMBLE.format(prefix=prefix, sqrt=""),
                constants,
                *hidden,
                *(table_text(writer, table) for table in tables),
                defaults,
                *documented,
                *entries,
            )
            if part
        ),
    )


INIT = "The state before the first sample; also what brings a unit back to its start."
STEP = "One sample: the state becomes the next one."
COMMAND = "One sample: the state becomes the next one; returns the command [V], which is also state->u."

PREAMBLE = """\
#include "{prefix}.h"

#include <float.h>
#include <math.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes results and takes away the tests for not-a-number"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "this target computes with more digits than the types have; on x86 use -msse2 -mfpmath=sse"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
"""


def header_text(
    prefix: str, about: str, records: Sequence[str], declared: Sequence[str], inlined: bool
) -> str:
    guard = f"{prefix.upper()}_H"
    return "\n".join(
        [
            comment(about),
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            "#include <stdbool.h>",
            "#include <stdint.h>",
            "",
            *records,
            *([] if inlined else [f"extern const {prefix}_parameters {prefix}_defaults;", ""]),
            *declared,
            "#endif",
            "",
        ]
    )


def declarations(unit: Unit, writer: Writer, inlined: bool) -> list[str]:
    """The declarations of ``init`` and ``step``, each below what it does."""
    said = (INIT, COMMAND if unit.command else STEP)
    pairs = zip(said, heads(unit, writer, inlined), strict=True)
    return [f"{comment(text)}{wrapped(f'{head};', 0)}\n" for text, head in pairs]


def heads(unit: Unit, writer: Writer, inlined: bool) -> tuple[str, str]:
    """The first lines of ``init`` and ``step``."""
    p = writer.prefix
    given = [] if inlined else [f"const {p}_parameters *parameters"]
    state = f"{p}_state *state"
    taken = [(name, record) for name, record in unit.arguments if writer.needed.kept(record)]
    arguments = [f"const {writer.type(record)} *{name}" for name, record in taken]
    result = writer.real if unit.command else "void"
    return (
        f"void {p}_init({', '.join([state, *given])})",
        f"{result} {p}_step({', '.join([state, *given, *arguments])})",
    )


def entry_texts(unit: Unit, writer: Writer, inlined: bool) -> list[str]:
    """The definitions of ``init`` and ``step``."""
    renamed = {"self": f"{writer.prefix}_fixed" if inlined else "parameters"}
    last = ["    return state->u;"] if unit.command else []
    texts = []
    for function, head, end in zip(
        (unit.init, unit.step), heads(unit, writer, inlined), ([], last), strict=True
    ):
        unread = not inlined and "self" not in dict(writer.needed.takes(function))
        first = ["    (void)parameters;"] if unread else []
        texts.append(writer.entry(function, head, renamed, {"self": not inlined}, Ends(first, end)))
    return texts


def nested(record: Any, needed: Needed, found: dict[Record, None]) -> None:
    """Adds a record to those found, after the records in it."""
    if not isinstance(record, Record) or record in found or not needed.kept(record):
        return
    for name, kind in record.fields.items():
        if needed.has(record, name):
            nested(kind, needed, found)
    found[record] = None


def used_records(unit: Unit, needed: Needed) -> Iterator[Any]:
    """Every type that functions take, hold and return."""
    yield unit.parameters
    for function in needed.reached:
        yield from (kind for _, kind in function.parameters)
        yield from function.locals.values()
        yield function.returns


def matrix_text(writer: Writer, matrix: Matrix) -> str:
    return f"typedef struct {{\n    double a[{matrix.size}][{matrix.size}];\n}} {writer.type(matrix)};\n"


def table_text(writer: Writer, table: Table) -> str:
    numbers = [writer.number(float(one))[0] for one in table.array.ravel()]
    rows = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    body = ",\n".join(f"    {row}" for row in rows)
    return f"static const {writer.real} {writer.prefix}_{table.name}[{len(numbers)}] = {{\n{body},\n}};\n"


def defaults_text(unit: Unit, writer: Writer, inlined: bool) -> str:
    """The object that holds the scenario's parameters."""
    name = f"{writer.prefix}_fixed" if inlined else f"{writer.prefix}_defaults"
    kind = f"{'static ' if inlined else ''}const {writer.prefix}_parameters"
    lines = defaults_lines(unit.block, unit.parameters, writer, 1)
    return "\n".join([f"{kind} {name} = {{", *lines, "};", ""])


def defaults_lines(block: Block, record: Record, writer: Writer, depth: int) -> Iterator[str]:
    pad = "    " * depth
    fields = declared_fields(record.cls) if record.cls else {}
    for name, kind in writer.kept(record):
        value = getattr(block, name)
        if isinstance(kind, Record):
            yield f"{pad}.{identifier(name)} = {{"
            yield from defaults_lines(value, kind, writer, depth + 1)
            yield f"{pad}}},"
        else:
            unit = fields[name].unit if name in fields else ""
            said = f" /* [{unit}] */" if unit else ""
            yield f"{pad}.{identifier(name)} = {writer.number(value)[0]},{said}"


def with_classes(functions: Sequence[Function], written: Sequence[str], unit: Unit) -> list[str]:
    """The functions, the first of each block's below what the block is: its equation, source and limits."""
    import inspect

    told: set[type] = set()
    found = []
    inner = [one for one in functions if one not in (unit.init, unit.step)]
    for function, text in zip(inner, written, strict=True):
        owner = function.owner
        if text and owner is not None and owner not in told and function.body:
            told.add(owner)
            found.append(comment(f"{owner.__name__}\n\n{inspect.getdoc(owner) or ''}"))
        found.append(text)
    return found
