"""Columns of a record, by the ending of its file."""

from array import array
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hydroservo.errors import ScenarioError, short
from hydroservo.inputs import exists
from hydroservo.scenario.records.binary import BINARY, read_binary_columns
from hydroservo.scenario.records.cells import Clock, Decimals, is_missing
from hydroservo.scenario.records.columns import TIME, Choose, Column, Record
from hydroservo.scenario.records.layout import text_table

LARGEST = 512 << 20  # bytes
RECORD_ENDINGS = (".csv", ".txt", *BINARY)
"""Of files that a page offers; text may have any other, too."""


def read_columns(path: Path, choose: Choose, period: float | None = None, *, gaps: bool = True) -> Record:
    """The chosen columns of a file, in SI units.

    Args:
        path: of the file: Parquet, MATLAB, NetCDF, HDF5, MDF or TDMS by its ending, else text.
        choose: the columns, by the headers.
        period: of the samples [s] where no column holds their instants.
        gaps: samples may be missing, and are nan; else each must be there.

    Raises:
        ScenarioError: in one line, the file, the place and what is wrong there.
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


def read_text_columns(path: Path, choose: Choose, largest: int, *, gaps: bool, fewest: int = 2) -> Record:
    """The chosen columns of a file of text, in its units.

    Rows in which all of them are empty count for nothing.

    Args:
        path: of the file.
        choose: the columns.
        largest: how many bytes it may have.
        gaps: a cell but that of an instant may be empty or nan, and rows may lack; else all are numbers.
        fewest: columns that it must have.
    """
    table = text_table(path, largest, fewest)
    columns = choose(table.headers, table.place)
    readers = [reader(column, table.decimals, gaps) for column in columns]
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
    return Record(columns, table.headers, {signal: np.array(samples) for signal, samples in values.items()})


def reader(column: Column, decimals: Decimals, gaps: bool) -> Callable[[str, int], float]:
    """What reads the cells of a column."""
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
