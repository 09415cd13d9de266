"""Curves from tables: of a file, or typed point by point."""

from typing import Any

from hydroservo.curve import Curve
from hydroservo.errors import ParameterError
from hydroservo.field import Field
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.recordings import axis_key, recorded
from hydroservo.scenario.tables import Entry, Table

__all__ = ["curve_from"]

POINTS = "points"


def curve_from(table: Table, field: Field | None) -> Curve:
    """The curve that a table names a file of, or whose points it has.

    A file is read by :func:`~hydroservo.scenario.recordings.recorded`; points are pairs of x and y, such as
    ``{points = [["0 m/s", "130 V/m"], ["0.25 m/s", "55 V/m"]]}``.

    Args:
        table: the table.
        field: the declaration of the curve; None where there is none.

    Raises:
        ScenarioError: the table, the file or a point is not what it must be.
    """
    if not table.has(POINTS):
        if not table.has("file"):
            like = f'{{file = "curve.csv", column = "y", {axis_key(field)} = "x"}}'
            raise table.error(f"a file is needed, or points: {like}")
        return recorded(table, field)
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
    """A point, in SI units.

    Raises:
        ScenarioError: it is none.
    """
    if not isinstance(entry.value, list) or len(entry.value) != 2:
        raise entry.error(f"must be a pair, as in {example(field)}")
    x, y = (
        coordinate(entry, one, unit) for one, unit in zip(entry.value, (field.over, field.unit), strict=True)
    )
    return x, y


def coordinate(entry: Entry, value: Any, unit: str) -> float:
    """One number of a point, in SI units.

    Raises:
        ScenarioError: it is none, or in another unit.
    """
    entry = entry._replace(value=value)
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
    x, y = (f"1 {unit}".strip() for unit in (field.over, field.unit))
    return f'[["0{x[1:]}", "0{y[1:]}"], ["{x}", "{y}"]]'
