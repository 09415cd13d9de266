"""A table of numbers in SI units, and its texts as they are read."""

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from enum import StrEnum
from numbers import Integral
from types import MappingProxyType
from typing import NamedTuple

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.formatting import (
    MINUS,
    NONE,
    Scale,
    brief,
    is_number,
    scale_of,
    scales_of,
    with_label,
    yes_or_no,
)

CellValue = str | float | int | bool | None


class Mark(StrEnum):
    """How a cell or a line stands out."""

    BEST = "best"
    GOOD = "good"
    BAD = "bad"
    DOUBTFUL = "doubtful"
    QUIET = "quiet"


class Cell(NamedTuple):
    """A text or a number of a table.

    Attributes:
        value: a number in SI units, a flag or a text; empty if None.
        unit: SI.
        mark: how it stands out.
    """

    value: CellValue = None
    unit: str = ""
    mark: Mark | None = None


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        heading: stands above it.
        unit: SI, of all its numbers; its heading then names the unit in which they are read.
        digits: of its numbers where they are read.
        right: it ends at the right, as numbers do, although its cells are texts.
    """

    heading: str
    unit: str = ""
    digits: int = 4
    right: bool = False


UNIT = Column("unit")
"""The column that names the unit of each row; its cells are empty."""


class Table(NamedTuple):
    """Cells in rows and columns.

    Where a column has a unit, its heading says it; where the table has the column ``UNIT``, that says the
    unit of each row; elsewhere it stands behind each number.

    Attributes:
        name: of its files.
        columns: from left to right.
        rows: a cell for each column.
        title: what it shows.
        note: stands beneath it.
        best: what follows "the best" where a cell is marked so, such as "of the runs that did not diverge".
        typed: units that a user wrote, by SI unit; they go before those that suit the numbers.
    """

    name: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    title: str = ""
    note: str = ""
    best: str = ""
    typed: Mapping[str, Scale] = MappingProxyType({})


class TableTexts(NamedTuple):
    """A table as it is read."""

    headings: list[str]  # with units
    right: list[bool]  # which columns end at the right
    rows: list[list[str]]  # the text of each cell


def texts_of(table: Table) -> TableTexts:
    """A table in the units of datasheets: one for each SI unit of its rows, or of a column."""
    columns = table.columns
    numbers = [
        (column.unit or cell.unit, [cell.value])
        for row in table.rows
        for column, cell in zip(columns, row, strict=True)
        if is_number(cell.value)
    ]
    scales = scales_of([*numbers, *((one.unit, ()) for one in columns)], table.typed)
    own = [scales[one.unit] if one.unit else None for one in columns]
    headings = [
        f"{one.heading} [{scale.label}]" if scale else one.heading
        for one, scale in zip(columns, own, strict=True)
    ]
    rows = []
    for row in table.rows:
        unit = unit_of_row(table, row)
        texts = []
        for column, scale, cell in zip(columns, own, row, strict=True):
            if column == UNIT:
                texts.append(scales[unit].label)
            elif scale:
                texts.append(text_of(cell.value, scale, column.digits))
            elif UNIT in columns and cell.unit == unit and is_number(cell.value):
                texts.append(text_of(cell.value, scales[unit], column.digits))
            else:
                texts.append(text_with_unit(cell, column.digits))
        rows.append(texts)
    return TableTexts(headings, [ends_right(table, j) for j in range(len(columns))], rows)


def note_of(table: Table, sign: str) -> str:
    """What stands beneath a table."""
    best = any(cell.mark is Mark.BEST for row in table.rows for cell in row)
    return " ".join(
        filter(None, [f"{sign} the best {table.best}".rstrip() + "." if best else "", table.note])
    )


def unit_of_row(table: Table, row: Sequence[Cell]) -> str:
    """The SI unit that the column ``UNIT`` says of a row: the first that a number in it has."""
    if UNIT not in table.columns:
        return ""
    return next((cell.unit for cell in row if cell.unit and is_number(cell.value)), "")


def ends_right(table: Table, j: int) -> bool:
    return table.columns[j].right or any(is_number(row[j].value) for row in table.rows)


def text_of(value: CellValue, scale: Scale, digits: int) -> str:
    """A value as it is read in a unit."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return yes_or_no(value)
    if isinstance(value, str):
        return value
    if isinstance(value, Integral) and not scale.label:
        return f"{value:,}".replace("-", MINUS)
    return NONE if math.isnan(value) else brief(scale.of(value), digits)


def text_with_unit(cell: Cell, digits: int) -> str:
    """A value with its unit behind it."""
    if not is_number(cell.value) or math.isnan(cell.value):
        return text_of(cell.value, Scale("", 1.0), digits)
    scale = scale_of([cell.value], cell.unit)
    return with_label(text_of(cell.value, scale, digits), scale.label)


def csv_of(table: Table) -> str:
    """A table as comma-separated values (RFC 4180, lines that end in LF), with all digits.

    Numbers are in SI units, and commands in the scenario's, which headings or rows name; flags are 0 or 1.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    units = [one.unit or shared_unit(table, j) for j, one in enumerate(table.columns)]
    writer.writerow(
        f"{column.heading} [{in_command_unit(unit)[0]}]" if unit else column.heading
        for column, unit in zip(table.columns, units, strict=True)
    )
    for row in table.rows:
        unit = unit_of_row(table, row)
        writer.writerow(
            in_command_unit(unit)[0] if column == UNIT else exact_text(cell, own, unit)
            for column, own, cell in zip(table.columns, units, row, strict=True)
        )
    return text.getvalue()


def shared_unit(table: Table, j: int) -> str:
    """The unit of all numbers of a column, where no column ``UNIT`` says it."""
    units = {row[j].unit for row in table.rows if is_number(value := row[j].value) and not math.isnan(value)}
    return units.pop() if len(units) == 1 and UNIT not in table.columns else ""


def exact_text(cell: Cell, own: str, of_row: str) -> str:
    """A value with all digits, and its unit where neither its column nor its row has that."""
    value = cell.value
    if isinstance(value, bool):
        return str(int(value))
    if not is_number(value) or math.isnan(value):
        return value if isinstance(value, str) else ""
    unit, factor = in_command_unit(cell.unit or own)
    number = int(value) if isinstance(value, Integral) and factor == 1.0 else factor * float(value)
    return f"{number!r} {unit}" if cell.unit not in ("", own, of_row) else repr(number)


LINES = re.compile(r"\s*\n\s*")

SPECIAL = {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    **{sign: rf"\{sign}" for sign in "&%$#_{}"},
    "-": "{-}",  # two of them are no dash
    "[": "{[}",  # no option of the row's end before it
    "*": "{*}",  # nor its star
    "\N{MINUS SIGN}": r"\ensuremath{-}",
    "\N{EN DASH}": "--",
    "\N{NO-BREAK SPACE}": "~",
    "\N{MULTIPLICATION SIGN}": r"\ensuremath{\times}",
    "\N{MIDDLE DOT}": r"\ensuremath{\cdot}",
    "\N{PLUS-MINUS SIGN}": r"\ensuremath{\pm}",
    "\N{INFINITY}": r"\ensuremath{\infty}",
    "\N{LESS-THAN OR EQUAL TO}": r"\ensuremath{\le}",
    "\N{GREATER-THAN OR EQUAL TO}": r"\ensuremath{\ge}",
    "\N{DEGREE SIGN}": r"\ensuremath{^\circ}",
    "\N{MICRO SIGN}": r"\ensuremath{\mu}",
    **{sign: rf"\ensuremath{{^{digit}}}" for sign, digit in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True)},
}
EACH = re.compile("|".join(map(re.escape, SPECIAL)))
MATHS = re.compile(r"(?<!\\)(\$(?:\\.|[^$\\])*\$)")  # between two signs of a dollar that are none


def latex_of(table: Table) -> str:
    r"""A table as LaTeX: a ``tabular`` with the rules of the package ``booktabs``, and nothing else.

    A paper puts ``\input{tables/metrics.tex}`` into its own ``table``, with its own caption; what is best is
    bold. Signs that LaTeX reads as commands are escaped.
    """
    texts = texts_of(table)
    rows = [
        [latex_bold(in_one_line(text), cell.mark is Mark.BEST) for text, cell in zip(*pair, strict=True)]
        for pair in zip(texts.rows, table.rows, strict=True)
    ]
    about = [LINES.sub(" ", text) for text in (table.title, note_of(table, "Bold:")) if text]
    lines = [
        *(f"% {text}" for text in about),
        "% needs \\usepackage{booktabs}",
        rf"\begin{{tabular}}{{{''.join('r' if right else 'l' for right in texts.right)}}}",
        r"\toprule",
        latex_line(list(map(in_one_line, texts.headings))),
        r"\midrule",
        *map(latex_line, rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def latex_line(texts: list[str]) -> str:
    return " & ".join(texts) + r" \\"


def latex_bold(text: str, best: bool) -> str:
    return rf"\textbf{{{text}}}" if best else text


def in_one_line(text: str) -> str:
    """Text that LaTeX sets as it stands, in one line."""
    return latex_escaped(LINES.sub(" ", text.strip()))


def latex_escaped(text: str) -> str:
    """Text that LaTeX sets as it stands."""
    return EACH.sub(lambda sign: SPECIAL[sign[0]], text)


def latex_label(text: str) -> str:
    r"""A text of a figure for LaTeX: maths as it is, all else escaped."""
    parts = MATHS.split(text)
    shown = [latex_escaped(one.replace(r"\$", "$")) for one in parts]
    shown[1::2] = [one.replace(r"\mathdefault", "") for one in parts[1::2]]
    return "".join(shown)
