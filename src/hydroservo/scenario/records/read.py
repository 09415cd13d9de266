"""Columns of a record, by the ending of its file; of a text, where its header stands and its rows begin."""

from array import array
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, islice, takewhile, zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydroservo.core.errors import ScenarioError, short
from hydroservo.core.inputs import exists, read_record_text
from hydroservo.scenario.records.binary import BINARY, read_binary_columns
from hydroservo.scenario.records.cells import (
    BLANKS,
    COMMA,
    DELIMITERS,
    Clock,
    Decimals,
    filled_cells,
    is_comment,
    is_instant,
    is_missing,
    numbered_lines,
    numbered_rows,
    parse_number,
    split_line,
)
from hydroservo.scenario.records.columns import (
    TIME,
    Choose,
    Header,
    RecordColumn,
    RecordedColumns,
    header_of,
    is_unit,
)

HEAD = 256  # lines, in which the first rows must be
COMMENT_SIGNS = "#%/! \t"
LARGEST = 512 << 20  # bytes
RECORD_ENDINGS = (".csv", ".txt", *BINARY)  # of files that a page offers; text may have any other, too


class TextTable(NamedTuple):
    """A table as it is read."""

    headers: list[Header]  # of its columns
    place: str  # where they stand, such as "line 1"
    rows: Iterator[tuple[int, list[str]]]  # line number and cells, as many as headers
    decimals: Decimals  # reads their numbers


class TextLayout(NamedTuple):
    """How a text may be laid out."""

    delimiter: str  # what separates its cells
    line: int  # the number of the header's line
    names: Sequence[str]  # the cells of the header
    units: Sequence[str]  # those of the line of units below it, if there is one
    start: int  # how many lines stand before the rows
    rank: int  # 2 if rows of numbers follow, 1 if the next line is as wide, else 0


def text_table(path: Path, largest: int, fewest: int = 2) -> TextTable:
    """Open a file of text whose rows are cells between commas, semicolons, tabs or blanks.

    The header is the last line of names in front of the first two rows of numbers, and below it may be a line
    of units; what stands before is passed over, as are comments. A comment in front of the rows is the header
    where no other line is.
    """
    name = str(path)
    text = read_record_text(path, largest, name)
    if "\0" in text[: 1 << 16]:
        raise ScenarioError(name, "line 1", "has null characters; save the file as UTF-8 text")
    lines = numbered_lines(text, name)
    head = list(islice(lines, HEAD))
    layout = find_layout(head, fewest, name)
    below, delimiter = head[layout.start :], layout.delimiter
    names = layout.names[: filled_cells(layout.names)]
    first = next((row for row in rows_in(below, delimiter) if filled_cells(row)), [])
    headers = [
        header_of(cell, i, unit, is_instant(value))
        for i, (cell, unit, value) in enumerate(
            islice(zip_longest(names, layout.units, first, fillvalue=""), len(names))
        )
    ]
    rows = numbered_rows(
        chain(below, lines), delimiter, len(names), max(len(first), min(len(names), 2)), name
    )
    return TextTable(headers, f"line {layout.line}", rows, Decimals(delimiter, name))


def find_layout(head: Sequence[tuple[int, str]], fewest: int, name: str) -> TextLayout:
    """The layout of a text by its first lines."""
    layouts = [found for delimiter in DELIMITERS if (found := layout_by(delimiter, head, fewest)) is not None]
    if not layouts:
        raise no_header(head, fewest, name)
    best = max(one.rank for one in layouts)
    possible = [one for one in layouts if one.rank == best]
    if best == 1 and len(possible) > 1:
        names = " or ".join(DELIMITERS[one.delimiter] for one in possible)
        problem = f"has cells that may be separated by {names}; keep one of them"
        raise ScenarioError(name, f"line {possible[0].line}", problem)
    return possible[0]


def no_header(head: Sequence[tuple[int, str]], fewest: int, name: str) -> ScenarioError:
    """That nothing in a text names columns."""
    lines = [(number, line) for number, line in head if line.strip() and not is_comment(line)]
    number, line = lines[0] if lines else (1, "")
    for delimiter in DELIMITERS:
        cells = split_line(line, delimiter)
        if filled_cells(cells) >= fewest and all(is_value(cell, delimiter) for cell in cells):
            return ScenarioError(name, f"line {number}", "must name the columns; these are numbers")
    names = "commas, semicolons, tabs or blanks"
    problem = "must name a column" if fewest == 1 else f"must name at least two columns, separated by {names}"
    return ScenarioError(name, f"line {number}", problem)


def layout_by(delimiter: str, head: Sequence[tuple[int, str]], fewest: int) -> TextLayout | None:
    """The layout of a text whose cells a sign separates; None if it names no columns."""
    lines = [
        CellLine(at, number, split_line(line, delimiter))
        for at, (number, line) in enumerate(head)
        if line.strip() and not is_comment(line)
    ]
    lines = [one for one in lines if filled_cells(one.cells)]
    for i, one in enumerate(lines):
        follows = lines[i + 1 : i + 2]
        alike = all(is_data(other, delimiter, len(one.cells)) for other in follows)
        if alike and is_data(one, delimiter, fewest):
            width = max(filled_cells(other.cells) for other in [one, *follows])
            if (layout := header_above(lines[:i], head[: one.at], delimiter, width)) is not None:
                return below_settings(layout, lines[:i])
    names = lines[0] if lines else None
    if names is not None and has_numbers(names, delimiter):  # beside texts
        return header_in_comment(head[: names.at], delimiter, filled_cells(names.cells))
    if names is None or delimiter == BLANKS or filled_cells(names.cells) < fewest:
        return None
    columns = filled_cells(names.cells)
    below = next((one.cells for one in lines if one.at > names.at), [""] * columns)
    agrees = filled_cells(below) <= columns <= len(below)
    return TextLayout(delimiter, names.number, names.cells, [], names.at + 1, int(agrees))


class CellLine(NamedTuple):
    """A line that holds cells: its place among the first lines, its number, and they."""

    at: int
    number: int
    cells: Sequence[str]


def header_above(
    lines: Sequence[CellLine], head: Sequence[tuple[int, str]], delimiter: str, width: int
) -> TextLayout | None:
    """The header of so many columns above the first row of numbers; None if there is none."""
    names = [one for one in lines if filled_cells(one.cells) >= width and not has_numbers(one, delimiter)]
    if not names:
        return header_in_comment(head, delimiter, width)
    last = names[-1]
    place = lines.index(last)
    previous = lines[place - 1] if place and filled_cells(lines[place - 1].cells) >= width else None
    units = all(is_unit(cell) for cell in last.cells if cell.strip())
    if units and previous is not None and not is_value(previous.cells[0], delimiter):  # "x-axis,1,2" too
        return TextLayout(delimiter, previous.number, previous.cells, last.cells, last.at + 1, 2)
    return TextLayout(delimiter, last.number, last.cells, [], last.at + 1, 2)


def header_in_comment(head: Sequence[tuple[int, str]], delimiter: str, width: int) -> TextLayout | None:
    """The header of so many columns in a comment just above the rows; None if there is none."""
    line_number, line = head[-1] if head else (0, "")
    cells = split_line(line.strip().lstrip(COMMENT_SIGNS), delimiter) if is_comment(line) else []
    if filled_cells(cells) != width:
        return None
    return TextLayout(delimiter, line_number, cells, [], len(head), 2)


def below_settings(layout: TextLayout, lines: Sequence[CellLine]) -> TextLayout:
    """A layout without the lines of settings that stand between its header and the rows."""
    below = takewhile(
        lambda one: is_setting(one, layout.delimiter), (one for one in lines if one.at >= layout.start)
    )
    return layout._replace(start=max((one.at + 1 for one in below), default=layout.start))


def is_setting(line: CellLine, delimiter: str) -> bool:
    """True for a line that begins with a word, and has nothing but words or two words and no more numbers."""
    cells = [cell for cell in line.cells if cell.strip()]
    words = sum(not is_value(cell, delimiter) for cell in cells)
    return not is_value(line.cells[0], delimiter) and (words == len(cells) or len(cells) <= 2 * words >= 4)


def is_data(line: CellLine, delimiter: str, fewest: int) -> bool:
    """True for a line of numbers and nothing else."""
    cells = [cell for cell in line.cells if cell.strip()]
    enough = len(line.cells) >= fewest and filled_cells(line.cells) > 0
    return enough and has_numbers(line, delimiter) and all(is_value(cell, delimiter) for cell in cells)


def has_numbers(line: CellLine, delimiter: str) -> bool:
    return any(is_value(cell, delimiter) and not is_missing(cell) for cell in line.cells)


def is_value(cell: str, delimiter: str) -> bool:
    """True for a cell that holds a number or an instant, or says that none is there."""
    text = cell.replace(",", ".") if delimiter != COMMA and cell.count(",") == 1 and "." not in cell else cell
    return is_missing(cell) or parse_number(text) is not None or is_instant(cell)


def rows_in(head: Sequence[tuple[int, str]], delimiter: str) -> Iterator[list[str]]:
    """The cells of the lines that are not comments."""
    return (split_line(line, delimiter) for _, line in head if not is_comment(line))


def read_columns(
    path: Path, choose: Choose, period: float | None = None, *, gaps: bool = True
) -> RecordedColumns:
    """The chosen columns of a file, in SI units; its ending says its format, and any other is text.

    Where no column holds the instants they are ``period`` [s] apart; samples may be missing where ``gaps``
    allows it, and are nan.
    """
    name = str(path)
    if not exists(path):
        raise ScenarioError(name, "", "there is no such file")
    if path.suffix.lower() in BINARY:
        record = read_binary_columns(path, choose, LARGEST, gaps=gaps)
    else:
        record = read_text_columns(path, choose, LARGEST, gaps=gaps, fewest=1 if period else 2)
    samples = {column.signal: column.in_si(record.samples[column.signal]) for column in record.columns}
    for column in record.columns:
        if np.isinf(samples[column.signal]).any():
            raise ScenarioError(name, f"column {column.header.text}", "has numbers that overflow in SI units")
    if period is not None:
        count = next(iter(samples.values())).size
        samples[TIME] = period * np.arange(count, dtype=np.float64)
    return record._replace(samples=samples)


def read_text_columns(
    path: Path, choose: Choose, largest: int, *, gaps: bool, fewest: int = 2
) -> RecordedColumns:
    """The chosen columns of a file of text, in its units.

    Rows in which all of them are empty count for nothing.
    """
    table = text_table(path, largest, fewest)
    columns = choose(table.headers, table.place)
    readers = [cell_reader(column, table.decimals, gaps) for column in columns]
    values = {column.signal: array("d") for column in columns}
    time = next((column for column in columns if column.signal == TIME), None)
    instants = values.get(TIME, array("d"))
    empty = 0
    for line, row in table.rows:
        cells = [row[column.header.place] for column in columns]
        if not any(map(str.strip, cells)):
            empty = empty or line
            continue
        if empty and not gaps:
            raise table.decimals.error(empty, columns[0].header.text, "is empty, and numbers follow")
        for samples, read, cell in zip(values.values(), readers, cells, strict=True):
            samples.append(read(cell, line))
        if time is not None and len(instants) > 1 and instants[-1] <= instants[-2]:
            problem = f"{short(row[time.header.place].strip())} is not after that in the row before"
            raise table.decimals.error(line, time.header.text, problem)
    table.decimals.check()
    return RecordedColumns(
        columns, table.headers, {signal: np.array(samples) for signal, samples in values.items()}
    )


def cell_reader(column: RecordColumn, decimals: Decimals, gaps: bool) -> Callable[[str, int], float]:
    text = column.header.text
    if column.header.clock and column.signal == TIME:
        clock = Clock()

        def instant(cell: str, line: int) -> float:
            seconds = clock.seconds(cell)
            if seconds is None:
                raise decimals.error(line, text, f"{short(cell)} must be a time of day, as in the first row")
            return seconds

        return instant
    may_lack = gaps and column.signal != TIME
    return lambda cell, line: np.nan if may_lack and is_missing(cell) else decimals.number(cell, line, text)
