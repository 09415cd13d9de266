"""Recorded signals from CSV files."""

import re
import warnings
from array import array
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import HydroservoWarning, ParameterError, ScenarioError, one_line, short
from hydroservo.field import Field
from hydroservo.inputs import exists
from hydroservo.nearest import one_of
from hydroservo.runs.record_coverage import remember_source
from hydroservo.scenario.decimals import Decimals
from hydroservo.scenario.quantities import unit_factor
from hydroservo.scenario.tables import Table
from hydroservo.scenario.text_table import text_table
from hydroservo.scenario.units import factor_and_dimension
from hydroservo.time_series import TimeSeries

__all__ = ["axis_key", "read_series", "recorded"]

LARGEST = 64 << 20  # bytes
LONGEST_UNIT = 32  # characters
UNIT = re.compile(r"\[([^][()]*)\]$|\(([^][()]*)\)$")  # at the end of a header cell
MASSES = {"lb": "lbf", "lbs": "lbf", "kg": "kgf"}  # that loggers call forces
BRACKETS = " []()"


class Column(NamedTuple):
    """A column of a file, as its header cell describes it."""

    header: str
    place: int  # in a row, from 0
    factor: Fraction  # SI units per unit of the cells
    unit: str  # as given; "" if none is


def recorded(table: Table, field: Field | None) -> TimeSeries:
    """The curve that a table ``{file = "demand.csv", column = "v", time = "t"}`` names.

    Args:
        table: the table.
        field: the declaration of the curve, which may be over something else than time: the key of that
            column is ``over`` then. None where there is none: units are those of the file.

    Raises:
        ScenarioError: the table or the file is not what it must be.
    """
    axis = axis_key(field)
    keys = ("file", "column", axis)
    for name in table.names():
        if name not in keys:
            raise table.entry(name).unknown(name, (*keys, "points"))
        if not isinstance(table.entry(name).value, str):
            raise table.entry(name).error("must be a string")
    file = table.entry("file")
    path = file.origin.folder / file.value
    if not exists(path):
        raise file.error(f"there is no such file in {short(str(file.origin.folder.absolute()))}")
    column, time = (table.entry(name).value if table.has(name) else None for name in keys[1:])
    return read_series(path, field, column, time)


def axis_key(field: Field | None) -> str:
    """The key that names the column of a curve's axis."""
    return "time" if field is None or field.over == "s" else "over"


def read_series(
    path: Path, field: Field | None, column: str | None = None, time: str | None = None
) -> TimeSeries:
    """A recorded signal from two columns of a CSV file, in SI units.

    The first line names the columns, each with its unit: "v [mm/s]", "F (kN)"; SI units where there is none,
    with a warning. Cells are separated by commas and have decimal points, or by semicolons or tabs and have
    decimal points or commas. Empty cells at the end of a line or of the two columns are nothing.

    Args:
        path: the file.
        field: the declaration of the signal, whose units the columns must have the dimensions of; None for
            any.
        column: name of the signal's column; the second one if None.
        time: name of the column of instants, or of what else the curve is over; the first one if None.

    Raises:
        ScenarioError: naming the file, the line and the column.
    """
    name = str(path)
    header, rows, decimals = text_table(path, LARGEST)
    over, own = (field.over, field.unit) if field else (None, None)
    t = column_named(header, time, 0, over, name)
    x = column_named(header, column, 1, own, name)
    instants, values = samples(rows, t, x, decimals)
    if instants.size < 2:
        raise ScenarioError(name, "", f"has {instants.size} rows of numbers; at least 2 are needed")
    try:
        series = TimeSeries.from_samples(scaled(instants, t.factor), scaled(values, x.factor))
    except ParameterError as error:
        raise ScenarioError(name, f"column {x.header}", str(error)) from None
    remember_source(series, f"{path.name}, {x.header} over {t.header}")
    for signal, unit in ((t, over), (x, own)):
        if unit and not signal.unit:
            warnings.warn(one_line(unitless(signal, unit, name)), HydroservoWarning, stacklevel=2)
    return series


def column_named(
    header: Sequence[str], wanted: str | None, default: int, unit: str | None, name: str
) -> Column:
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
        problem = f"column {short(cell)} {error}{advice(given, unit, wanted, axis=not default)}"
        raise ScenarioError(name, "line 1", problem) from None
    return Column(cell, places[0], factor, given)


def advice(given: str, unit: str | None, wanted: str | None, *, axis: bool) -> str:
    """What may help with a unit that does not fit."""
    if unit == "N" and given in MASSES:
        return f"; that is a mass, and the force is {MASSES[given]}"
    if axis and unit == "":
        return f'; full = "1 {given}" beside the file says what 100 % is'
    return "" if wanted else "; another column is chosen by its name, as time and column of the series"


def unitless(column: Column, unit: str, name: str) -> str:
    """The warning of a column whose header gives no unit."""
    better = f'write "{column.header} [{unit}]", or the unit that it is in'
    return f"{name}: column {short(column.header)} has no unit and is read in {unit}; {better}"


def name_and_unit(cell: str) -> tuple[str, str]:
    match = UNIT.search(cell)
    if match is None:
        return cell, ""
    return cell[: match.start()].rstrip(), (match[1] or match[2] or "").strip()


def samples(
    rows: Iterator[tuple[int, list[str]]], t: Column, x: Column, decimals: Decimals
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Instants, or what the curve is over, strictly increasing, and the signal there, in the file's units."""
    instants, values = array("d"), array("d")
    for line, text_t, text_x in filled(rows, t, x, decimals):
        if line == 2 and is_unit(text_t) and is_unit(text_x):
            better = f"{name_and_unit(t.header)[0]} [{text_t.strip(BRACKETS)}]"
            raise ScenarioError(decimals.name, "line 2", f'holds units; they belong in line 1: "{better}"')
        instant = decimals.number(text_t, line, t.header)
        if instants and instant <= instants[-1]:
            problem = f"{short(text_t)} is not after that in the row before"
            raise decimals.error(line, t.header, problem)
        instants.append(instant)
        values.append(decimals.number(text_x, line, x.header))
    decimals.check()
    return np.array(instants), np.array(values)


def filled(
    rows: Iterator[tuple[int, list[str]]], t: Column, x: Column, decimals: Decimals
) -> Iterator[tuple[int, str, str]]:
    """The number of each line and its two cells, until the two columns end."""
    empty = 0
    for line, row in rows:
        if not row[t.place].strip() and not row[x.place].strip():
            empty = empty or line
        elif empty:
            raise decimals.error(empty, t.header, "is empty, and numbers follow")
        else:
            yield line, row[t.place], row[x.place]


def is_unit(text: str) -> bool:
    """True for a cell that holds the name of a unit, as many loggers write below that of the column."""
    try:
        return len(text) <= LONGEST_UNIT and bool(factor_and_dimension(text.strip(BRACKETS))[1])
    except ValueError:
        return False


def scaled(values: NDArray[np.float64], factor: Fraction) -> NDArray[np.float64]:
    """Values in SI units; division by a whole number is correctly rounded where its inverse is not."""
    with np.errstate(over="ignore"):  # what is too large is refused as not finite
        return values * float(factor) if factor >= 1 else values / float(1 / factor)
