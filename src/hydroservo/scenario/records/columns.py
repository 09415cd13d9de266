"""Which column of a record holds which signal, and how its numbers become SI units."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import ScenarioError, short
from hydroservo.field import Field
from hydroservo.nearest import nearest, one_of
from hydroservo.scenario.quantities import number_and_unit, si_value, unit_factor
from hydroservo.scenario.records.headers import Header, name_and_unit, places_of
from hydroservo.scenario.units import factor_and_dimension

__all__ = [
    "Column",
    "ColumnSource",
    "among",
    "choose_columns",
    "column_source",
    "find_header",
    "names_of",
    "scale_example",
    "scaled_column",
]

KEYS = ("column", "scale", "offset")
NAMED = 12  # columns in a message, of more
MASSES = {"lb": "lbf", "lbs": "lbf", "kg": "kgf"}  # that loggers call forces


class ColumnSource(NamedTuple):
    """What a user says of the column of a signal.

    Attributes:
        column: its name, with the unit that it is in where its header gives another or none; "" for the
            usual one.
        scale: of the signal per unit of the column, such as "0.25 V/mA"; "" where units convert.
        offset: of the signal where the column is 0, such as "-62.5 bar"; "" for none.
    """

    column: str = ""
    scale: str = ""
    offset: str = ""


class Column(NamedTuple):
    """A column of a record: the signal is ``factor`` times its numbers, and ``offset``.

    Attributes:
        signal: what it holds.
        header: as the file has it.
        place: its number, from 0 on.
        factor: SI units per unit of its numbers.
        offset: in SI units.
    """

    signal: str
    header: Header
    place: int
    factor: Fraction = Fraction(1)
    offset: float = 0.0

    def in_si(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Numbers of the column in SI units.

        Division by a whole number is correctly rounded where multiplication by its inverse is not.
        """
        with np.errstate(over="ignore"):  # what is too large is refused as not finite
            many = abs(self.factor) >= 1
            scaled = values * float(self.factor) if many else values / float(1 / self.factor)
            return scaled + self.offset if self.offset else scaled


def column_source(value: Any) -> ColumnSource:
    """What a name of a column, or a table ``{ column = "I [mA]", scale = "0.25 V/mA" }``, says.

    Raises:
        ValueError: it is neither; the message says what is wrong with it.
    """
    if isinstance(value, str):
        return ColumnSource(value)
    if not isinstance(value, Mapping):
        raise ValueError('must be the name of a column, such as "v_piston [mm/s]"')
    for key, text in value.items():
        if key not in KEYS:
            raise ValueError(f"has the unknown key {short(key)}; it {one_of(str(key), KEYS)}")
        if not isinstance(text, str):
            example = {"column": "I [mA]", "scale": "0.25 V/mA"}.get(key, "-62.5 bar")
            raise ValueError(f'has {key} = {short(text)}, which must be a string such as "{example}"')
    return ColumnSource(**value)


def choose_columns(
    headers: Sequence[Header],
    sources: Mapping[str, ColumnSource],
    signals: Mapping[str, tuple[Field, Sequence[str]]],
    where: tuple[str, str],
) -> list[Column]:
    """The columns that hold signals.

    Args:
        headers: of all columns.
        sources: what the user says of the columns of signals.
        signals: that are sought, with the usual names of their columns.
        where: the file, and the place in it where the headers stand.

    Raises:
        ScenarioError: a column that the user names is missing, or one appears twice or has another unit.
    """
    columns = []
    for signal, (field, usual) in signals.items():
        source = sources.get(signal, ColumnSource())
        names = [source.column] if source.column else usual
        found = next(filter(None, (find_header(name, headers, where) for name in names)), None)
        if found is not None:
            place, unit = found
            header = headers[place]
            try:
                columns.append(scaled_column(signal, field, (header, place), unit, source))
            except ValueError as error:
                problem = f"column {short(header.text)} {error}{advice(signal, field, header)}"
                raise ScenarioError(*where, problem) from None
        elif source.column:
            name = name_and_unit(source.column)[0]
            raise ScenarioError(
                *where, f"column {short(name)} for {signal} is missing; {among(name, headers)}"
            )
    return columns


def find_header(wanted: str, headers: Sequence[Header], where: tuple[str, str]) -> tuple[int, str] | None:
    """The place of the column of a name, or of a name and a unit, and that unit; None if there is none.

    Raises:
        ScenarioError: there are two.
    """
    places, unit = places_of(wanted, headers), ""
    if not places:
        name, unit = name_and_unit(wanted)
        places = places_of(name, headers) if unit else []
    if len(places) > 1:
        raise ScenarioError(*where, f"column {short(headers[places[0]].name)} appears more than once")
    return (places[0], unit) if places else None


def scaled_column(
    signal: str, field: Field, found: tuple[Header, int], unit: str, source: ColumnSource
) -> Column:
    """A column as that of a signal.

    Args:
        signal: its name.
        field: its declaration.
        found: the header and its place.
        unit: that the user gives; "" for that of the header.
        source: what the user says of it.

    Raises:
        ValueError: its numbers are not in a unit of the signal's dimension.
    """
    header, place = found
    if header.clock and field.unit == "s":
        return Column(signal, header, place)
    factor = column_factor(source.scale, unit or header.unit, field.unit)
    return Column(
        signal, header, place, factor, si_value(source.offset, field.unit) if source.offset else 0.0
    )


def column_factor(scale: str, unit: str, si_unit: str) -> Fraction:
    """SI units of a signal per unit of its column.

    Raises:
        ValueError: they have another dimension, or there is no unit.
    """
    if not scale:
        if not unit and si_unit:
            raise ValueError("has no unit")
        return unit_factor(unit, si_unit)
    try:
        number, given = number_and_unit(scale)
    except ValueError:
        raise ValueError(f"has the scale {short(scale)}, which must be such as '0.25 V/mA'") from None
    over, stroke, under = given.rpartition("/")
    products = [f"({given}) ({unit})" if given and unit else given or unit]
    if stroke and (not unit or under.strip(" ()") == unit):
        products.insert(bool(not unit), over)  # the column's own unit, whatever it is, goes out
    if not number:
        raise ValueError(f"has the scale {scale}, which must not be 0")
    si_factor, si_dimension = factor_and_dimension(si_unit)
    for product in products:
        with suppress(ValueError):
            factor, dimension = factor_and_dimension(product)
            if dimension == si_dimension:
                return number * factor / si_factor
    raise ValueError(f"times {scale} does not convert to {si_unit}")


def advice(signal: str, field: Field, header: Header) -> str:
    """What to write where a column has no unit, or one of another dimension."""
    key = f"; write [identify.columns] {signal} ="
    if not header.unit:
        return f'{key} "{header.name} [{field.unit}]", or the unit that it is in'
    if field.unit == "N" and header.unit in MASSES:
        return f'; that is a mass: {key[2:]} "{header.name} [{MASSES[header.unit]}]"'
    return f'{key} {{ column = "{header.text}", scale = "{scale_example(field, header)}" }}'


def scale_example(field: Field, header: Header) -> str:
    """A scale that would do."""
    return f"NUMBER {bracketed(field.unit)}/{bracketed(header.unit)}"


def bracketed(unit: str) -> str:
    return f"({unit})" if set(unit) & set("/ ") else unit


def among(name: str, headers: Sequence[Header]) -> str:
    """Which columns there are, and which may be meant."""
    return f"it must be one of {names_of(headers)}{nearest(name, [one.name for one in headers])}"


def names_of(headers: Sequence[Header]) -> str:
    """The first of the columns, and how many more there are."""
    names = [one.text for one in headers if one.text]
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return f"{', '.join(names[:NAMED])}{more}"
