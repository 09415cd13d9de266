"""Recorded signals of a scenario: a demand, a load."""

import math
import warnings
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from hydroservo.core.errors import HydroservoWarning, ParameterError, ScenarioError, one_line, short
from hydroservo.core.field import Field
from hydroservo.core.inputs import exists
from hydroservo.core.time_series import TimeSeries
from hydroservo.runs.cautions.records import remember_source
from hydroservo.scenario.quantities import si_value, unit_factor
from hydroservo.scenario.records.columns import (
    TIME,
    ColumnSource,
    Header,
    RecordColumn,
    column_choices,
    column_offset,
    find_header,
    name_and_unit,
    scale_advice,
    scaled_column,
)
from hydroservo.scenario.records.read import read_columns
from hydroservo.scenario.tables import LayeredTable

VALUE = "value"
KEYS = ("file", "column", "scale", "offset")
NUMBERS = ("period", "offset")  # which may be numbers, in SI units


def read_curve(table: LayeredTable, field: Field | None) -> TimeSeries:
    """The curve that a table ``{file = "demand.csv", column = "v", time = "t"}`` names."""
    axis, keys = axis_key(field), curve_keys(field)
    for name in table.names():
        if name not in keys:
            raise table.entry(name).unknown(name, (*keys, "points"))
        value = table.entry(name).value
        number = name in NUMBERS and isinstance(value, int | float) and not isinstance(value, bool)
        if not number and not isinstance(value, str):
            raise table.entry(name).error("must be a string")
    file = table.entry("file")
    path = file.origin.folder / file.value
    if not exists(path):
        raise file.error(f"there is no such file in {short(str(file.origin.folder.absolute()))}")
    texts = {name: table.entry(name).value for name in keys[1:] if table.has(name)}
    period = period_in(table) if axis == TIME else None
    if period is not None and table.has(TIME):
        raise table.entry("period").error(f"is given beside {table.key(TIME)}; give only one of them")
    texts.pop("period", None)
    return read_series(path, field, time=texts.pop(axis, None), period=period, **texts)


def period_in(table: LayeredTable) -> float | None:
    """The time between samples that a table gives [s]; None if it gives none."""
    if not table.has("period"):
        return None
    entry = table.entry("period")
    try:
        return sample_period(entry.value)
    except ValueError as error:
        raise entry.error(str(error)) from None


def axis_key(field: Field | None) -> str:
    """The key that names the column of what a curve is over."""
    return TIME if field is None or field.over == "s" else "over"


def curve_keys(field: Field | None) -> tuple[str, ...]:
    """The keys of a table that names a curve's file."""
    axis = axis_key(field)
    return (*KEYS, axis, "period") if axis == TIME else (*KEYS, axis)


def sample_period(value: Any) -> float:
    """The time between samples that a quantity or a number says [s]."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ValueError('must be a time, such as "10 ms"')
    period = si_value(value, "s") if isinstance(value, str) else float(value)
    if not 0.0 < period < math.inf:
        raise ValueError("must be above 0")
    return period


def read_series(
    path: Path,
    field: Field | None,
    column: str | None = None,
    time: str | None = None,
    period: float | None = None,
    scale: str = "",
    offset: str | float = 0.0,
) -> TimeSeries:
    """A recorded signal from two columns of a file, in SI units.

    Headers give units: "v [mm/s]", "F (kN)"; SI units where there is none, with a warning. Empty cells at the
    end of a line or of the two columns are nothing. Without names the axis is the first column and the signal
    the second, or the first where the samples have a ``period`` [s].
    """
    name = str(path)
    axis = Field(field.over, "axis") if field else None

    def choose(headers: Sequence[Header], place: str) -> list[RecordColumn]:
        where = (name, place)
        default = 0 if period is not None else 1
        value = column_at(VALUE, field, headers, column, default, ColumnSource("", scale, offset), where)
        if period is not None:
            return [value]
        return [column_at(TIME, axis, headers, time, 0, ColumnSource(), where), value]

    record = read_columns(path, choose, period, gaps=False)
    instants, values = record.samples[TIME], record.samples[VALUE]
    if instants.size < 2:
        raise ScenarioError(name, "", f"has {instants.size} rows of numbers; at least 2 are needed")
    text = record.columns[-1].header.text
    try:
        series = TimeSeries.from_samples(instants, values)
    except ParameterError as error:
        raise ScenarioError(name, f"column {text}", str(error)) from None
    over = record.columns[0].header.text if period is None else f"samples every {period:g} s"
    remember_source(series, f"{path.name}, {text} over {over}")
    units = {TIME: field.over, VALUE: field.unit} if field else {}
    for one in record.columns:
        unit = units.get(one.signal)
        if unit and not one.unit and not (one.signal == VALUE and scale):
            header = one.header.text
            better = f'write "{header} [{unit}]", or the unit that it is in'
            line = f"{name}: column {short(header)} has no unit and is read in {unit}; {better}"
            warnings.warn(one_line(line), HydroservoWarning, stacklevel=2)
    return series


def column_at(
    signal: str,
    field: Field | None,
    headers: Sequence[Header],
    name: str | None,
    default: int,
    source: ColumnSource,
    where: tuple[str, str],
) -> RecordColumn:
    """The column with a name, or the one at a place where no name is given.

    A column without a unit is taken to be in SI units; one without a declaration is read in its own.
    """
    match = find_header(name, headers, where) if name is not None else None
    if name is None and default < len(headers):
        match = headers[default], ""
    if match is None:
        missing = name_and_unit(name or "")[0]
        problem = f"column {short(missing)} is missing; {column_choices(missing, headers)}"
        raise ScenarioError(*where, problem)
    header, unit = match
    if field is None:
        own = unit or header.unit
        column = scaled_column(signal, Field(own, ""), header, unit, source)
        return column._replace(factor=column.factor * unit_factor(own, None))
    if field.unit and not (unit or header.unit or header.clock or source.scale):
        return RecordColumn(signal, header, "", Fraction(1), column_offset(source.offset, field.unit))
    try:
        return scaled_column(signal, field, header, unit, source)
    except ValueError as error:
        hint = f"; {scale_advice(field, header)}"
        if source.scale or source.offset:
            hint = ""
        elif signal == TIME and not field.unit:
            hint = f'; full = "1 {header.unit}" beside the file says what 100 % is'
        elif name is None:
            hint = "; another column is chosen by its name, as time and column of the series"
        raise ScenarioError(*where, f"column {short(header.text)} {error}{hint}") from None
