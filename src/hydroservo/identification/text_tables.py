"""Logs as text: cells between commas, semicolons or tabs."""

from array import array
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import short
from hydroservo.identification.columns import Column
from hydroservo.identification.signals import TIME
from hydroservo.scenario.text_table import text_table

__all__ = ["Choose", "read_text_table"]

LARGEST = 512 << 20  # bytes
Choose = Callable[[Sequence[str]], Sequence[Column]]  # of the headers
Samples = dict[str, NDArray[np.float64]]


def read_text_table(path: Path, choose: Choose) -> tuple[Samples, list[str]]:
    """The chosen columns of a CSV file, in the file's units, and all headers.

    The first line names the columns. An empty cell, or nan, is a sample that is missing, but for the time.

    Args:
        path: of the file.
        choose: the columns.

    Raises:
        ScenarioError: naming the file, the line and the column.
    """
    headers, rows, decimals = text_table(path, LARGEST)
    columns = choose(headers)
    found = {one.signal: array("d") for one in columns}
    time = found[TIME]
    for line, row in rows:
        if not any(map(str.strip, row)):
            continue
        for one in columns:
            cell = row[one.place]
            absent = one.signal != TIME and cell.strip().lower() in ("", "nan")
            found[one.signal].append(np.nan if absent else decimals.number(cell, line, one.header))
        if len(time) > 1 and time[-1] <= time[-2]:
            said = short(row[columns[0].place].strip())
            raise decimals.error(
                line, columns[0].header, f"{said} is not after the instant in the row before"
            )
    decimals.check()
    return {signal: np.array(values) for signal, values in found.items()}, headers
