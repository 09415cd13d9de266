"""A file of text whose first line names columns, and whose other lines are rows of them."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from hydroservo.errors import ScenarioError
from hydroservo.inputs import read_text
from hydroservo.scenario.decimals import Decimals, number
from hydroservo.scenario.delimited import delimiter, numbered_rows

__all__ = ["TextTable", "text_table"]


class TextTable(NamedTuple):
    """A table as it is read.

    Attributes:
        headers: the cells of the first line.
        rows: the number of each other line and its cells, as many as there are headers.
        decimals: reads their numbers.
    """

    headers: list[str]
    rows: Iterator[tuple[int, list[str]]]
    decimals: Decimals


def text_table(path: Path, largest: int) -> TextTable:
    """Open a CSV file.

    Args:
        path: of the file.
        largest: how many bytes it may have.

    Raises:
        ScenarioError: it cannot be read, is larger, or its first line has numbers and no names.
    """
    name = str(path)
    text = read_text(path, largest, name)
    mark = delimiter(text, name)
    rows = numbered_rows(text, mark, name)
    headers = next(rows)[1]
    if all(number(cell.replace(",", ".")) is not None for cell in headers):
        raise ScenarioError(name, "line 1", "must name the columns; these are numbers")
    return TextTable(headers, rows, Decimals(mark, name))
