"""Recorded signals from CSV files."""

import csv
import math
import re
from array import array
from collections.abc import Iterator, Sequence
from fractions import Fraction
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ParameterError, ScenarioError, short
from hydroservo.field import Field
from hydroservo.scenario.files import exists, read_text
from hydroservo.scenario.names import one_of
from hydroservo.scenario.quantities import unit_factor
from hydroservo.scenario.tables import Table
from hydroservo.time_series import TimeSeries

__all__ = ["read_series", "recorded"]

LARGEST = 64 << 20  # bytes
LONGEST_LINE = 1 << 16  # characters
KEYS = ("file", "column", "time")
UNIT = re.compile(r"\[([^][()]*)\]$|\(([^][()]*)\)$")  # at the end of a header cell


class Column(NamedTuple):
    """A column of a file, as its header cell describes it."""

    header: str
    place: int  # in a row, from 0
    factor: Fraction  # SI units per unit of the cells


def recorded(table: Table, field: Field) -> TimeSeries:
    """The signal that a table ``{file = "demand.csv", column = "v", time = "t"}`` names.

    Raises:
        ScenarioError: the table or the file is not what it must be.
    """
    for name in table.names():
        if name not in KEYS:
            raise table.entry(name).unknown(name, KEYS)
        if not isinstance(table.entry(name).value, str):
            raise table.entry(name).error("must be a string")
    if not table.has("file"):
        raise table.error('a file is needed: {file = "demand.csv", column = "v", time = "t"}')
    file = table.entry("file")
    path = file.origin.folder / file.value
    if not exists(path):
        raise file.error(f"there is no such file in {short(str(file.origin.folder.absolute()))}")
    names = {name: table.entry(name).value if table.has(name) else None for name in KEYS[1:]}
    return read_series(path, field, **names)


def read_series(path: Path, field: Field, column: str | None = None, time: str | None = None) -> TimeSeries:
    """A recorded signal from two columns of a CSV file, in SI units.

    The first line names the columns, each with its unit: "v [mm/s]", "F (kN)"; SI units where there is none.

    Args:
        path: the file.
        field: the declaration of the signal, whose unit the column must have the dimension of.
        column: name of the signal's column; the second one if None.
        time: name of the column of instants; the first one if None.

    Raises:
        ScenarioError: naming the file, the line and the column.
    """
    name = str(path)
    rows = numbered_rows(read_text(path, LARGEST, name), name)
    header = next(rows, (1, []))[1]
    if len(header) < 2:
        raise ScenarioError(name, "line 1", "must name at least two columns, separated by commas")
    if all(is_number(text) for text in header):
        raise ScenarioError(name, "line 1", "must name the columns; these are numbers")
    t = column_named(header, time, 0, "s", name)
    x = column_named(header, column, 1, field.unit, name)
    instants, values = samples(rows, t, x, name)
    if instants.size < 2:
        raise ScenarioError(name, "", f"has {instants.size} rows of numbers; at least 2 are needed")
    try:
        return TimeSeries.from_samples(scaled(instants, t.factor), scaled(values, x.factor))
    except ParameterError as error:
        raise ScenarioError(name, f"column {x.header}", str(error)) from None


def numbered_rows(text: str, name: str) -> Iterator[tuple[int, list[str]]]:
    """The rows of a CSV text with the number of their line, all as long as the first."""
    reader = csv.reader(short_lines(text, name), strict=True)
    width = None
    try:
        for row in reader:
            width = width or len(row)
            if len(row) != width:
                problem = f"has {len(row)} cells; the first line has {width}"
                raise ScenarioError(name, f"line {reader.line_num}", problem)
            yield reader.line_num, row
    except csv.Error as error:
        raise ScenarioError(name, f"line {reader.line_num}", f"is not CSV: {error}") from None


def short_lines(text: str, name: str) -> Iterator[str]:
    for number, line in enumerate(StringIO(text.rstrip(), newline=""), 1):
        if len(line) > LONGEST_LINE:
            raise ScenarioError(name, f"line {number}", f"is longer than {LONGEST_LINE} characters")
        yield line


def column_named(header: Sequence[str], wanted: str | None, default: int, unit: str, name: str) -> Column:
    """The column that is wanted, by its name or its whole header cell.

    Raises:
        ScenarioError: there is none, or more than one, or its unit has another dimension than ``unit``.
    """
    cells = [(text.strip(), *name_and_unit(text.strip())) for text in header]
    places = [i for i, cell in enumerate(cells) if wanted in cell[:2]] if wanted is not None else [default]
    if len(places) != 1:
        names = [cell[1] for cell in cells]
        problem = "appears more than once" if places else f"is missing; it {one_of(wanted or '', names)}"
        raise ScenarioError(name, "line 1", f"column {short(wanted)} {problem}")
    cell, _, given = cells[places[0]]
    try:
        factor = unit_factor(given, unit) if given else Fraction(1)
    except ValueError as error:
        raise ScenarioError(name, "line 1", f"column {short(cell)} {error}") from None
    return Column(cell, places[0], factor)


def name_and_unit(cell: str) -> tuple[str, str]:
    match = UNIT.search(cell)
    if match is None:
        return cell, ""
    return cell[: match.start()].rstrip(), (match[1] or match[2] or "").strip()


def samples(
    rows: Iterator[tuple[int, list[str]]], t: Column, x: Column, name: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Instants, strictly increasing, and the signal there, in the units of the file."""
    instants, values = array("d"), array("d")
    for line, row in rows:
        instant = number(row, t, line, name)
        if instants and instant <= instants[-1]:
            problem = f"{short(row[t.place])} is not after the instant in the row before"
            raise ScenarioError(name, f"line {line}, column {t.header}", problem)
        instants.append(instant)
        values.append(number(row, x, line, name))
    return np.array(instants), np.array(values)


def number(row: Sequence[str], column: Column, line: int, name: str) -> float:
    """The finite number in a cell."""
    text = row[column.place]
    if not is_number(text):
        problem = (
            f"{short(text)} must be a finite number" if text.strip() else "is empty; it must be a number"
        )
        raise ScenarioError(name, f"line {line}, column {column.header}", problem)
    return float(text)


def is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text)) and "_" not in text
    except ValueError:
        return False


def scaled(values: NDArray[np.float64], factor: Fraction) -> NDArray[np.float64]:
    """Values in SI units; division by a whole number is correctly rounded where its inverse is not."""
    return values * float(factor) if factor >= 1 else values / float(1 / factor)
