"""A block as a reader wants to see it: a line for each block in it, or a table of all its numbers."""

from collections.abc import Iterator
from html import escape
from math import isnan
from typing import NamedTuple

import numpy as np

from hydroservo.core.block import Block, in_signal, is_block, signal_below, signal_of
from hydroservo.core.command_scale import is_volts
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.formatting import common_unit
from hydroservo.show import Mark
from hydroservo.show.html import html_row

WIDTH = 110  # characters of a line
DIGITS = 5  # a datasheet has no more
HEADS = ("name", "value", "unit", "meaning")


class OutlineNode(NamedTuple):
    """A block in a block."""

    path: str
    block: Block
    same: bool  # as one of hydroservo's own blocks has it by default
    signal: Field | None  # what the loop, or a law, controls


class Entry(NamedTuple):
    """One number of a block, as it is read."""

    name: str
    value: str
    unit: str
    meaning: str
    same: bool  # as the class has it by default

    def __str__(self) -> str:
        return f"{self.name} {self.value} {self.unit}".rstrip()


def outline(block: Block) -> str:
    """A block as text: its type, then a line for each block in it with the numbers that fit.

    What differs from the defaults of a class comes first. Numbers have the units of datasheets, and five
    digits. What hydroservo's own blocks nest by default is left out, for their defaults are neutral or right
    for nearly all; of blocks of one's own every nested block is shown.

    Args:
        block: such as a loop, a machine or a controller.
    """
    parts = [part for part in nodes_of(block) if not part.same]
    names = [indented(part.path) for part in parts]
    width = max(map(len, names))
    return "\n".join(line(part, name and f"{name:<{width}}") for part, name in zip(parts, names, strict=True))


def outline_table(block: Block) -> str:
    """All numbers of a block and of the blocks in it as HTML: name, value, unit and meaning.

    Each block of a loop has a line of its own, which opens when clicked upon. Values that differ from the
    defaults of their class are bold.

    Args:
        block: such as a loop, a machine or a controller.
    """
    groups: list[list[OutlineNode]] = []
    for part in nodes_of(block):
        if "." not in part.path:
            groups.append([])
        groups[-1].append(part)
    return "\n".join(section(group) for group in groups)


def nodes_of(
    block: Block, path: str = "", same: bool = False, outer: Field | None = None
) -> Iterator[OutlineNode]:
    """A block and the blocks in it, depth first."""
    signal = signal_of(block, outer)
    yield OutlineNode(path, block, same, signal)
    for name, value in block._asdict().items():
        if is_block(value) and not is_volts(value):
            known = path and type(block).__module__.startswith("hydroservo.")
            default = known and alike(value, block._field_defaults.get(name))
            if name == "controls" and path:  # a law's own, which is worth a line where it is not its loop's
                default = default or signal == outer
            below = signal_below(block, name, signal)
            yield from nodes_of(value, f"{path}.{name}" if path else name, same or bool(default), below)


def alike(value: object, other: object) -> bool:
    """Whether two blocks, numbers or arrays are of one type and hold the same."""
    if is_block(value):
        return type(value) is type(other) and all(map(alike, value, other))  # type: ignore[call-overload]
    if isinstance(value, float) and isinstance(other, float):
        return value == other or (isnan(value) and isnan(other))
    return bool(np.array_equal(value, other))  # type: ignore[arg-type]


def indented(path: str) -> str:
    """The last name of a path, by its depth."""
    return f"{'  ' * (path.count('.') + 1)}{path.rpartition('.')[2]}  " if path else ""


def entries_of(part: OutlineNode) -> list[Entry]:
    """The numbers of a block, in declared order."""
    block = part.block
    fields, defaults = declared_fields(block.__class__), block._field_defaults
    found = []
    for name, value in block._asdict().items():
        if is_block(value) or value is None:
            continue
        field = in_signal(fields.get(name, Field("", name)), part.signal)
        text, unit = value_and_unit(value, field)
        same = name in defaults and alike(value, defaults[name])
        found.append(Entry(name, text, unit, field.meaning, same))
    return found


def value_and_unit(value: object, field: Field) -> tuple[str, str]:
    """A number with few digits, and its unit."""
    if isinstance(value, np.ndarray):
        return f"{value.size} numbers", field.unit
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value), ""
    if field.auto is not None and value == field.auto:
        return "auto", ""
    if isinstance(value, int):
        return str(value), field.unit
    unit, factor = common_unit([value], field.unit)
    return f"{value * factor:.{DIGITS}g}", unit


def line(part: OutlineNode, start: str) -> str:
    """A block's name, its type, and as many of its numbers as a line holds, changed ones first."""
    start += type(part.block).__name__
    entries = [entry for entry in entries_of(part) if entry.value != "nan"]
    texts = [str(entry) for entry in sorted(entries, key=lambda entry: entry.same)]
    shown = list(texts)
    while len(joined(start, shown, texts)) > WIDTH and shown:
        shown.pop()
    return joined(start, shown, texts)


def joined(start: str, shown: list[str], texts: list[str]) -> str:
    """A line with some of the numbers, and a mark where others are left out."""
    if not texts:
        return start
    return f"{start}: {', '.join(shown) if len(shown) == len(texts) else ', '.join([*shown, '...'])}"


def section(parts: list[OutlineNode]) -> str:
    """A block and those in it as HTML: a line with their types, and the table behind it."""
    first, *nested = parts
    types = ", ".join(type(part.block).__name__ for part in nested)
    summary = f"{heading(first)} <small>{escape(types)}</small>" if types else heading(first)
    rows = "".join([*rows_of(first), *(row for part in nested for row in headed(part, rows_of(part)))])
    if not rows:
        return f"<div>{summary}</div>"
    heads = html_row(HEADS, tag="th")
    return f"<details><summary>{summary}</summary><table>{heads}{rows}</table></details>"


def heading(part: OutlineNode) -> str:
    """The path of a block, and its type."""
    return f"{escape(part.path)} <b>{escape(type(part.block).__name__)}</b>".strip()


def headed(part: OutlineNode, rows: list[str]) -> list[str]:
    """The rows of a block, if it has any, below its path and type."""
    title = f"{part.path} {type(part.block).__name__}".strip()
    return [html_row([title], tag="th", span=len(HEADS)), *rows] if rows else []


def rows_of(part: OutlineNode) -> list[str]:
    """A row for each number of a block."""
    return [
        html_row(
            (entry.name, entry.value, entry.unit, entry.meaning), (None, None if entry.same else Mark.BEST)
        )
        for entry in entries_of(part)
    ]
