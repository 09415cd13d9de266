"""The rows of a text of cells, however they are separated."""

import csv
from collections.abc import Iterator, Sequence
from contextlib import suppress
from io import StringIO
from itertools import islice

from hydroservo.errors import ScenarioError

__all__ = ["COMMA", "delimiter", "numbered_rows"]

LONGEST_LINE = 1 << 16  # characters
COMMA = ","
DELIMITERS = {COMMA: "commas", ";": "semicolons", "\t": "tabs"}


def delimiter(text: str, name: str) -> str:
    """What separates the cells: that of comma, semicolon and tab with which the first two rows agree.

    Raises:
        ScenarioError: two of them do, or the first line names fewer than two columns with each.
    """
    if text[:4].lower() == "sep=":
        raise ScenarioError(name, "line 1", "is not the names of the columns but a hint to Excel; remove it")
    if "\0" in text[:LONGEST_LINE]:
        raise ScenarioError(name, "line 1", "has null characters; save the file as UTF-8 text")
    starts = {mark: first_rows(text, mark, name) for mark in DELIMITERS}
    possible = [mark for mark, (header, *_) in starts.items() if filled_columns(header) > 1]
    agreeing = [
        mark
        for mark in possible
        if all(fits(row, filled_columns(starts[mark][0])) for row in starts[mark][1:])
    ]
    if len(agreeing) > 1:
        names = " or ".join(DELIMITERS[mark] for mark in agreeing)
        raise ScenarioError(name, "line 1", f"has cells that may be separated by {names}; keep one of them")
    if not possible:
        names = "commas, semicolons or tabs"
        raise ScenarioError(name, "line 1", f"must name at least two columns, separated by {names}")
    return (agreeing or possible)[0]


def first_rows(text: str, mark: str, name: str) -> list[list[str]]:
    """The first two rows, as far as they can be read."""
    reader = csv.reader(short_lines(text[: 4 * LONGEST_LINE], name), delimiter=mark, strict=True)
    rows: list[list[str]] = []
    with suppress(csv.Error):
        rows.extend(islice(reader, 2))
    return rows or [[]]


def filled_columns(header: Sequence[str]) -> int:
    """How many cells a row has, but for empty ones at its end, which spreadsheets write."""
    return max((i for i, cell in enumerate(header, 1) if cell.strip()), default=0)


def fits(row: Sequence[str], columns: int) -> bool:
    """True for a row with a cell for each column and nothing after them, and for an empty row."""
    return filled_columns(row) <= columns <= len(row) or not filled_columns(row)


def numbered_rows(text: str, mark: str, name: str) -> Iterator[tuple[int, list[str]]]:
    """The rows with the number of their line, each with as many cells as the first has columns.

    Raises:
        ScenarioError: one has more or fewer, or quotes that do not match.
    """
    reader = csv.reader(short_lines(text, name), delimiter=mark, strict=True)
    columns = 0
    try:
        for row in reader:
            columns = columns or filled_columns(row)
            if len(row) != columns and not fits(row, columns):
                raise ScenarioError(name, f"line {reader.line_num}", misfit(row, columns, mark))
            yield reader.line_num, row[:columns] if len(row) >= columns else [""] * columns
    except csv.Error as error:
        raise ScenarioError(name, f"line {reader.line_num}", f"is not CSV: {error}") from None


def misfit(row: Sequence[str], columns: int, mark: str) -> str:
    """What is wrong with a row of another length than the first."""
    if len(row) == 1 and len(row[0].split()) == columns:
        return f"is separated by blanks, and the first line by {DELIMITERS[mark]}; one of them must go"
    advice = (
        "; with decimal commas, semicolons must separate them" if mark == COMMA and len(row) > columns else ""
    )
    return f"has {len(row)} cells; the first line has {columns}{advice}"


def short_lines(text: str, name: str) -> Iterator[str]:
    for number, line in enumerate(StringIO(text.rstrip("\r\n"), newline=""), 1):
        if len(line) > LONGEST_LINE:
            raise ScenarioError(name, f"line {number}", f"is longer than {LONGEST_LINE} characters")
        yield line
