"""A table of a report: text in rows and columns, and the file of it that a spreadsheet reads."""

import csv
import io
from collections.abc import Sequence
from typing import NamedTuple


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        heading: what stands above it.
        number: it holds numbers, which end at the right.
    """

    heading: str
    number: bool = False


class Table(NamedTuple):
    """Text in rows and columns.

    Attributes:
        name: of its files.
        columns: from left to right.
        rows: a text for each column.
        title: what it shows.
        note: what stands beneath it.
        marked: row and column of each text that stands out, from 0.
    """

    name: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[str]]
    title: str = ""
    note: str = ""
    marked: frozenset[tuple[int, int]] = frozenset()


def csv_text(table: Table) -> str:
    """A table as comma-separated values (RFC 4180, lines that end in LF): the headings, then the rows.

    Args:
        table: whose texts are written as they are read, in the units that its columns or rows name.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.heading for column in table.columns])
    writer.writerows(table.rows)
    return text.getvalue()
