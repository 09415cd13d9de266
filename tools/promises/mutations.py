"""Changes of scenarios, by the structure of their tables and by their characters."""

import math
import random
import tomllib
from collections.abc import Iterator, Sequence
from datetime import date
from functools import cache
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError
from hydroservo.core.field import declared_fields
from hydroservo.core.group import group_class
from hydroservo.runs.provenance import block_tables
from hydroservo.scenario.build import Draft
from hydroservo.scenario.registry import makers, shipped_classes
from hydroservo.scenario.tables import parse_toml

Draw = random.Random
Tables = dict[str, Any]

NUMBERS = (
    0,
    1,
    -1,
    2,
    2**31,
    2**53 + 1,
    2**63 - 1,
    -(2**63),
    0.0,
    -0.0,
    5e-324,
    1e-12,
    1e-3,
    0.5,
    1e3,
    1e9,
    1e200,
)
WORDS = (
    "auto",
    "",
    " ",
    "steady",
    "1",
    "1/3",
    "1/0",
    "-",
    "nan",
    "inf",
    "\x00",
    "\u202e",
    "\ud7ff",
    "x" * 5000,
)
UNITS = (
    "",
    "bar",
    "Pa",
    "mm",
    "m",
    "kg",
    "N",
    "V",
    "L/min",
    "s",
    "Hz",
    "deg",
    "%",
    "m/s",
    "cm^2",
    "V s/m",
    "m^",
    "degC",
)
OTHERS: tuple[Any, ...] = (
    True,
    False,
    math.nan,
    math.inf,
    -math.inf,
    [],
    [1],
    [[]],
    {},
    {"type": "x"},
    date(2000, 1, 1),
)
KEYS = (
    "type",
    "base",
    "title",
    "start",
    "vary",
    "given",
    "scale",
    "usual",
    "file",
    "model",
    "controls",
    "é",
    "",
    "a.b",
)
TOKENS = (
    "[",
    "]",
    "[[",
    "=",
    '"',
    "'",
    '"""',
    ".",
    ",",
    "{",
    "}",
    "#",
    "\n",
    "\r",
    "\0",
    "\ufeff",
    "e9",
    "-",
    "_",
    "1e999",
)


@cache
def types() -> tuple[str, ...]:
    """What ``type`` may name anywhere."""
    return tuple(name for cls in shipped_classes() for name in makers(cls))


def canonical(loop: Loop) -> Tables:
    """A loop's canonical tables as a scenario takes them: without what is computed before a run."""
    tables = block_tables(loop)
    del tables["type"], tables["metrics"]
    tables["controls"] = block_tables(loop.controls)
    without_derived(loop, tables)
    return tables


def without_derived(block: Any, tables: Tables) -> None:
    if type(block) is group_class(block._fields):
        return
    for name, field in declared_fields(type(block)).items():
        if field.derived:
            tables.pop(name, None)
    for name, inner in tables.items():
        if isinstance(inner, dict):
            without_derived(getattr(block, name), inner)


def drawn_value(draw: Draw) -> Any:
    """A value that a key may be given, sensible or not."""
    kind = draw.randrange(6)
    if kind == 0:
        return draw.choice(NUMBERS)
    if kind == 1:
        return draw.choice(OTHERS)
    if kind == 2:
        return draw.choice(WORDS)
    if kind == 3:
        return draw.choice(types())
    number = draw.choice(
        (f"{10.0 ** draw.uniform(-12, 12):.4g}", str(draw.choice(NUMBERS)), f"{draw.random():.3g}")
    )
    return f"{number} {draw.choice(UNITS)}" if kind == 4 else float(number)


def mutated_tables(tables: Tables, others: Sequence[Tables], draw: Draw) -> Tables:
    """A scenario after a few changes of its keys, values and tables.

    Args:
        tables: the scenario's.
        others: those of scenarios that parts may come from.
        draw: says what is changed.
    """
    found = copied(tables)
    for _ in range(draw.choice((1, 1, 1, 2, 2, 3, 5))):
        change(found, others, draw)
    return found


def change(tables: Tables, others: Sequence[Tables], draw: Draw) -> None:
    places = list(tables_in(tables))
    table = draw.choice(places)
    names = list(table)
    how = draw.randrange(8)
    if not names or how == 0:
        table[draw.choice((*KEYS, *names, "unheard"))] = copied(drawn_value(draw))
        return
    name = draw.choice(names)
    if how == 1:
        del table[name]
    elif how == 2 and "type" in table:
        table["type"] = draw.choice(types())
    elif how == 3:
        table[typo(name, draw)] = copied(table[name])
    elif how == 4:  # a part of another scenario
        source = draw.choice(list(tables_in(draw.choice(others))))
        table[draw.choice((name, *source))] = copied(draw.choice(list(source.values()) or [{}]))
    elif how == 5 and isinstance(table[name], int | float):
        table[name] = table[name] * 10.0 ** draw.randint(-9, 9)
    elif how == 6:
        table[name] = copied(draw.choice(places))
    else:
        table[name] = copied(drawn_value(draw))


def copied(value: Any) -> Any:
    return {name: copied(one) for name, one in value.items()} if isinstance(value, dict) else value


def tables_in(tables: Tables) -> Iterator[Tables]:
    yield tables
    for one in tables.values():
        if isinstance(one, dict):
            yield from tables_in(one)


def typo(name: str, draw: Draw) -> str:
    """A name that is not quite another."""
    at = draw.randrange(len(name) + 1)
    return draw.choice((name[:at] + name[at + 1 :], name[:at] + "x" + name[at:], name.upper(), f"{name}_a"))


def mutated_text(text: str, other: str, draw: Draw) -> bytes:
    """A text after changes that know nothing of its structure."""
    found = text
    for _ in range(draw.choice((1, 1, 2, 4))):
        first, last = sorted(draw.randrange(len(found) + 1) for _ in range(2))
        last = min(last, first + draw.choice((0, 1, 8, 400)))
        beside = draw.randrange(len(other) + 1)
        piece = draw.choice(
            (
                draw.choice(TOKENS),
                found[first:last] * 2,
                other[beside : beside + 200],
                "",
                str(draw.choice(NUMBERS)),
            )
        )
        found = found[:first] + piece + found[last:]
    content = bytearray(found.encode("utf-8", "replace"))
    if content and draw.random() < 0.3:
        content[draw.randrange(len(content))] = draw.randrange(256)
    return bytes(content)


def tables_of(text: str) -> Tables | None:
    """The tables of a text, if it is one of a scenario."""
    try:
        return parse_toml(text, "")
    except (ScenarioError, tomllib.TOMLDecodeError):
        return None


def numbers_of(drafts: Any, prefix: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Path, declaration and value of each number that a scenario may give."""
    for name, one in drafts.items():
        if isinstance(one, Draft):
            fields = declared_fields(one.maker)
            for inner, value in one.members.items():
                if not isinstance(value, Draft) and inner in fields and not fields[inner].derived:
                    yield f"{prefix}{name}.{inner}", fields[inner], value
            yield from numbers_of(
                {key: value for key, value in one.members.items() if isinstance(value, Draft)},
                f"{prefix}{name}.",
            )
