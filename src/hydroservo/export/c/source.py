"""The header and the source of an exported unit."""

import inspect
import textwrap
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hydroservo.core.block import Block, nested_signal
from hydroservo.core.field import Field
from hydroservo.export.c.writer import CWriter, FunctionEnds, NamedConstant
from hydroservo.export.layout import INDENT, lay_out
from hydroservo.export.texts import WIDTH, comment, in_comment
from hydroservo.export.translation import Translation, declarations_by_name, ordered_records
from hydroservo.export.unit import Part
from hydroservo.language.liveness import Liveness
from hydroservo.language.names import identifier
from hydroservo.language.terms import ConstantArray, Record


class SourceForm(NamedTuple):
    """How a unit is written."""

    prefix: str  # of public names and of types
    real: str  # "double" or "float"
    inlined: bool  # the parameters are a constant of the source
    about: str  # the comment on top of both files
    hash: str  # of the scenario
    version: str  # of hydroservo


INIT = "The state before the first sample; also what brings a unit back to its start."
STEP = "One sample: the state becomes the next one."
PURPOSES = {  # of init and step
    Part.CONTROLLER: (INIT, f"{STEP[:-1]}; returns the command [{{command}}], which is also state->u."),
    Part.EQUATIONS: (
        "The state at the start, without a command.",
        "The rates of a machine, and what else can be seen of it, at an instant and in any state of it.",
    ),
}

PREAMBLE = """\
#include "{prefix}.h"

#include <float.h>
#include <math.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "compile without -ffast-math and its parts: they change results"
#endif
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ != 0)
#error "compile without -ffinite-math-only: it takes away the tests for not-a-number"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16) /* 16: of _Float16 */
#error "this target computes with more digits than the types have; on x86 use -msse2 -mfpmath=sse"
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off") /* it ignores the standard's own pragma */
#else
#pragma STDC FP_CONTRACT OFF
#if (defined(FP_FAST_FMA) || defined(FP_FAST_FMAF)) && !defined(__clang__) && !defined({PREFIX}_FUSES_NONE)
#error "this compiler may fuse a*b + c: switch that off, and define {PREFIX}_FUSES_NONE"
#endif
#endif
"""

HEADER = """\
{about}
#ifndef {guard}_H
#define {guard}_H

#include <stdbool.h>
#include <stdint.h>

#define {guard}_SCENARIO "{hash}" /* hash of the scenario */
#define {guard}_VERSION "{version}" /* of hydroservo, which wrote this */

#ifdef __cplusplus
extern "C" {{
#endif

{body}
#ifdef __cplusplus
}}
#endif

#endif
"""


def source_texts(translation: Translation, needed: Liveness, form: SourceForm) -> tuple[str, str]:
    """Header and source of a unit."""
    writer = CWriter(form.prefix, form.real, needed, translation.signals())
    state = translation.init.returns
    public = [translation.parameters] * (not form.inlined) + [
        state,
        *(record for _, record in translation.arguments),
    ]
    shown = ordered_records(public, needed)
    hidden = [record for record in ordered_records(translation.records, needed) if record not in shown]
    functions = documented_functions(translation, writer)
    entries = entry_texts(translation, writer, form.inlined)
    read = any("self" in dict(needed.takes(one)) for one in (translation.init, translation.step))
    defaults = defaults_text(translation, writer, form.inlined) if read or not form.inlined else ""
    tables = [table_text(writer, table) for table in translation.tables if table in needed.tables]
    constants = [constant_text(one) for one in writer.constants.values()]  # those now seen
    parts = [
        comment(form.about),
        PREAMBLE.format(prefix=form.prefix, PREFIX=form.prefix.upper()),
        "".join(constants),
        *(writer.record(record) for record in hidden),
        *tables,
        defaults,
        *functions,
        *entries,
    ]
    records = [writer.record(one) for one in shown]
    header = header_text(form, records, entry_declarations(translation, writer, form.inlined))
    return header, lay_out(join_sections(parts))


def constant_text(one: NamedConstant) -> str:
    """A constant, below what it was computed from."""
    return f"{comment(one.text) if one.text else ''}#define {one.name} {one.number}\n"


def join_sections(parts: Sequence[str]) -> str:
    return "\n".join(part for part in parts if part)


def header_text(form: SourceForm, records: Sequence[str], declared: Sequence[str]) -> str:
    defaults = f"extern const {form.prefix}_parameters {form.prefix}_defaults;\n"
    body = lay_out(join_sections([*records, "" if form.inlined else defaults, *declared]))
    guard = form.prefix.upper()
    return HEADER.format(
        about=comment(form.about), guard=guard, hash=form.hash, version=form.version, body=body
    )


def entry_declarations(translation: Translation, writer: CWriter, inlined: bool) -> list[str]:
    """The declarations of ``init`` and ``step``, each below what it does."""
    purposes = PURPOSES.get(translation.part, (INIT, STEP))
    state = translation.init.returns
    command = state.units.get("u", "V") if isinstance(state, Record) else "V"
    texts = [text.format(command=command) for text in purposes]
    pairs = zip(texts, heads(translation, writer, inlined), strict=True)
    return [f"{comment(text)}{head};\n" for text, head in pairs]


def heads(translation: Translation, writer: CWriter, inlined: bool) -> tuple[str, str]:
    """The first lines of ``init`` and ``step``."""
    p = writer.prefix
    given = [] if inlined else [f"const {p}_parameters *parameters"]
    state = f"{p}_state *state"
    taken = [(name, record) for name, record in translation.arguments if writer.needed.kept(record)]
    arguments = [f"const {writer.type(record)} *{name}" for name, record in taken]
    result = writer.real if translation.part is Part.CONTROLLER else "void"
    return (
        f"void {p}_init({', '.join([state, *given])})",
        f"{result} {p}_step({', '.join([state, *given, *arguments])})",
    )


def entry_texts(translation: Translation, writer: CWriter, inlined: bool) -> list[str]:
    """The definitions of ``init`` and ``step``."""
    renamed = {"self": f"{writer.prefix}_fixed" if inlined else "parameters"}
    last = ["return state->u;"] if translation.part is Part.CONTROLLER else []
    texts = []
    for function, head, end in zip(
        (translation.init, translation.step), heads(translation, writer, inlined), ([], last), strict=True
    ):
        read = dict(writer.needed.takes(function)) | ({"self": None} if inlined else {})
        first = [
            f"(void){renamed.get(name, name)};"
            for name, kind in function.parameters
            if name not in read and writer.needed.kept(kind)
        ]
        texts.append(writer.entry(function, head, renamed, {"self": not inlined}, FunctionEnds(first, end)))
    return texts


def table_text(writer: CWriter, table: ConstantArray) -> str:
    numbers = [writer.number(float(one))[0] for one in table.array.ravel()]
    body = textwrap.fill(", ".join(numbers), WIDTH - len(INDENT))
    return f"static const {writer.real} {writer.prefix}_{table.name}[{len(numbers)}] = {{\n{body}\n}};\n"


def defaults_text(translation: Translation, writer: CWriter, inlined: bool) -> str:
    """The object that holds the scenario's parameters."""
    name = f"{writer.prefix}_fixed" if inlined else f"{writer.prefix}_defaults"
    kind = f"{'static ' if inlined else ''}const {writer.prefix}_parameters"
    lines = defaults_lines(translation.block, translation.parameters, writer, translation.signal)
    return "\n".join([f"{kind} {name} = {{", *lines, "};", ""])


def defaults_lines(block: Block, record: Record, writer: CWriter, signal: Field | None) -> Iterator[str]:
    fields = declarations_by_name(record, [signal])
    for name, kind in writer.kept(record):
        value = getattr(block, name)
        if isinstance(kind, Record):
            yield f".{identifier(name)} = {{"
            yield from defaults_lines(value, kind, writer, nested_signal(block, name, signal))
            yield "},"
        else:
            unit = fields[name].unit if name in fields else ""
            said = f" /* [{in_comment(unit)}] */" if unit else ""
            yield f".{identifier(name)} = {writer.number(value)[0]},{said}"


def documented_functions(translation: Translation, writer: CWriter) -> list[str]:
    """The functions, the first of each block's below what the block is: its equation, source and limits."""
    documented: set[type] = set()
    texts = []
    for function in writer.needed.reached:
        if function in (translation.init, translation.step):
            continue
        owner = function.owner
        if owner is not None and owner not in documented and function.body:
            documented.add(owner)
            texts.append(comment(f"{owner.__name__}\n\n{inspect.getdoc(owner) or ''}"))
        texts.append(writer.function(function))
    return texts
