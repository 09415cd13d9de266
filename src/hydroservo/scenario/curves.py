"""Curves from tables: of a file, or typed point by point."""

from dataclasses import replace
from typing import Any

from hydroservo.curve import Curve
from hydroservo.errors import ParameterError
from hydroservo.field import Field
from hydroservo.scenario.quantities import number_and_unit, si_value, unit_factor
from hydroservo.scenario.records.series import axis_key, recorded
from hydroservo.scenario.tables import Entry, Layer, Table

FULL, POINTS = "full", "points"


def curve_from(table: Table, field: Field | None) -> Curve:
    """The curve that a table names a file of, or whose points it has.

    A file is read by :func:`~hydroservo.scenario.records.recorded`; points are pairs of x and y, such as
    ``{points = [["0 m/s", "130 V/m"], ["0.25 m/s", "55 V/m"]]}``. Of a curve over a share, ``full = "10 V"``
    says what 100 % is where its axis has another unit.
    """
    if field is None or field.over or not table.has(FULL):
        return points(table, field) if table.has(POINTS) else of_file(table, field)
    entry = table.entry(FULL)
    try:
        size, unit = number_and_unit(entry.value if isinstance(entry.value, str) else "", "V")
        unit_factor(unit, None)
    except ValueError as error:
        raise entry.error(str(error)) from None
    if not size > 0.0:
        raise entry.error("must be above 0")
    found = curve_from(without(table, FULL), replace(field, over=unit))
    return Curve.from_samples(found.knots / float(size), found.samples)


def without(table: Table, name: str) -> Table:
    """A table without a key."""
    layers = [
        Layer(origin, {key: value for key, value in given.items() if key != name})
        for origin, given in table.layers
    ]
    return table._replace(layers=tuple(layers))


def of_file(table: Table, field: Field | None) -> Curve:
    """The curve of a file."""
    if not table.has("file"):
        like = f'{{file = "curve.csv", column = "y", {axis_key(field)} = "x"}}'
        raise table.error(f"a file is needed, or points: {like}")
    return recorded(table, field)


def points(table: Table, field: Field | None) -> Curve:
    """The curve whose points a table has."""
    for name in table.names():
        if name != POINTS:
            raise table.entry(name).error(f"stands beside {table.key(POINTS)}; give one of them")
    entry, declared = table.entry(POINTS), field or Field("", "", over="")
    if not isinstance(entry.value, list):
        raise entry.error(f"must be a list of pairs: {example(declared)}")
    pairs = [
        pair(Entry(entry.origin, f"{entry.key}[{i}]", one), declared) for i, one in enumerate(entry.value)
    ]
    try:
        return Curve.from_samples([x for x, _ in pairs], [y for _, y in pairs])
    except ParameterError as error:
        raise entry.error(str(error)) from None


def pair(entry: Entry, field: Field) -> tuple[float, float]:
    """A point, in the units of its declaration."""
    if not isinstance(entry.value, list) or len(entry.value) != 2:
        raise entry.error(f"must be a pair, as in {example(field)}")
    x, y = entry.value
    return coordinate(entry._replace(value=x), field.over), coordinate(entry._replace(value=y), field.unit)


def coordinate(entry: Entry, unit: str) -> float:
    """One number of a point, in a unit."""
    value: Any = entry.value
    if isinstance(value, str):
        try:
            return si_value(value, unit)
        except ValueError as error:
            raise entry.error(str(error)) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise entry.error("must be a number, or one with a unit")
    return float(value)


def example(field: Field) -> str:
    """Two points as they are typed."""
    (x0, y0), (x1, y1) = ([f"{n} {unit}".strip() for unit in (field.over, field.unit)] for n in (0, 1))
    return f'[["{x0}", "{y0}"], ["{x1}", "{y1}"]]'
