"""The rows of a text of cells, however they are separated."""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from io import StringIO

from hydroservo.errors import ScenarioError

LONGEST_LINE = 1 << 16  # characters
COMMA = ","
BLANKS = " "
DELIMITERS = {COMMA: "commas", ";": "semicolons", "\t": "tabs", BLANKS: "blanks"}
WORD = re.compile(r'"([^"]*)"|(\S+(?:[ ]?(?:\[[^]]*\]|\([^)]*\)))?)')  # a unit belongs to the word before it
NUMBER = re.compile(r"\s*[-+]?[.,]?[0-9]")
COMMENTS = ("#", "%", "//", "!", "sep=", "SEP=")  # "sep=;" is a hint to spreadsheets


def numbered_lines(text: str, name: str) -> Iterator[tuple[int, str]]:
    """The lines of a text and their numbers."""
    for number, line in enumerate(StringIO(text.rstrip("\r\n"), newline=""), 1):
        if len(line) > LONGEST_LINE:
            raise ScenarioError(name, f"line {number}", f"is longer than {LONGEST_LINE} characters")
        yield number, line


def is_comment(line: str) -> bool:
    """True for a line that holds no cells, with a sign in front that says so."""
    return line.lstrip().startswith(COMMENTS)


def split_line(line: str, delimiter: str) -> list[str]:
    """The cells of one line."""
    if delimiter == BLANKS:
        return [quoted or word for quoted, word in WORD.findall(line)]
    with suppress(csv.Error):
        return next(csv.reader([line], delimiter=delimiter, strict=True), [])
    return []


def filled_cells(row: Sequence[str]) -> int:
    """How many cells a row has, but for empty ones at its end, which spreadsheets write."""
    return max((i for i, cell in enumerate(row, 1) if cell.strip()), default=0)


def numbered_rows(
    lines: Iterable[tuple[int, str]], delimiter: str, columns: int, fewest: int, name: str
) -> Iterator[tuple[int, list[str]]]:
    """The rows with the number of their line, each with as many cells as there are columns.

    Args:
        lines: and their numbers; comments among them are left out.
        delimiter: what separates their cells.
        columns: that the header has.
        fewest: cells that a row may have, as the first one does; what it lacks at its end is empty.
        name: the file that an error names.
    """
    number = 0

    def cells() -> Iterator[str]:
        nonlocal number
        for number, line in lines:  # noqa: B007 - it is the place of an error
            if not is_comment(line) or filled_cells(split_line(line, delimiter)) >= columns:
                yield line

    reader: Iterator[list[str]] = (
        (split_line(line, BLANKS) for line in cells())
        if delimiter == BLANKS
        else csv.reader(cells(), delimiter=delimiter, strict=True)
    )
    try:
        for row in reader:
            filled = filled_cells(row)
            fits = filled <= columns if len(row) >= columns else len(row) >= fewest
            if filled and not fits:
                raise ScenarioError(name, f"line {number}", misfit(row, columns, delimiter))
            yield number, [*row[:columns], *[""] * (columns - len(row))]
    except csv.Error as error:
        raise ScenarioError(name, f"line {number}", f"is not CSV: {error}") from None


def misfit(row: Sequence[str], columns: int, delimiter: str) -> str:
    """What is wrong with a row of another length than the header."""
    if len(row) == 1 and len(row[0].split()) == columns and NUMBER.match(row[0]):
        return f"is separated by blanks, and the header by {DELIMITERS[delimiter]}; separate all lines alike"
    commas = delimiter == COMMA and len(row) > columns
    advice = "; with decimal commas, semicolons must separate them" if commas else ""
    return f"has {len(row)} cell{'s' * (len(row) > 1)}; the header has {columns}{advice}"
