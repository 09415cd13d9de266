"""Which column of a record holds which signal, and how its numbers become SI units."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ScenarioError, nearest, one_of, short
from hydroservo.core.field import Field
from hydroservo.scenario.quantities import number_and_unit, si_value, unit_factor
from hydroservo.scenario.units import OffsetUnitError, factor_and_dimension

LONGEST_UNIT = 32  # characters
UNIT = re.compile(r"\s*(?:\[([^][]*)\]|\(((?:[^()]|\([^()]*\))*)\))$")  # at the end of a header
INDEX = re.compile(r"\S\[[0-9]+\]$")  # of a column of a matrix, as data[1]
WORD_BREAK = re.compile(r"[\s_-]+")
BRACKETS = " []()"
DASHES = ("-", "--")  # for no unit; a 1 in a line would be a number
RATIOS = ("%", "1/1")
INDEX_NAME = "index"  # of a first column without a name, as pandas writes its index
LABELS = ("unit", "units", "unit:", "units:")  # in front of a line of units
TIME = "time"
KEYS = ("column", "scale", "offset")
NAMED = 12  # at most so many columns are named in a message
FORCES = {("N", "lb"): "lbf", ("N", "lbs"): "lbf", ("N", "kg"): "kgf"}  # units that loggers have for them


class Header(NamedTuple):
    """What a file says of a column."""

    text: str  # as the file has it, such as "velocity [mm/s]"
    name: str  # without the unit
    place: int  # the number of the column, from 0 on
    unit: str = ""  # "" if none is given
    clock: bool = False  # its cells are dates or times of day


def header_of(text: str, place: int, unit: str = "", clock: bool = False) -> Header:
    """The header that a text is, with a unit from elsewhere where it has none itself."""
    name, own = name_and_unit(text.strip())
    unit = own or unit.strip().strip(BRACKETS)
    unit = "1" if unit in (*DASHES, "1") else "" if unit.casefold() in LABELS else unit
    name = name or (INDEX_NAME if place == 0 else "")
    whole = text.strip() if own else f"{name} [{unit}]" if unit else name
    return Header(whole, name, place, unit, clock)


def name_and_unit(text: str) -> tuple[str, str]:
    """The parts of "velocity [mm/s]", "Force (kN)" or "time / s"; no unit is ""."""
    name, stroke, unit = text.partition(" / ")
    if stroke and is_unit(unit):
        return name.strip(), unit.strip().strip(BRACKETS)
    match = UNIT.search(text)
    if match is not None and not INDEX.search(text):
        return text[: match.start()], (match[1] or match[2] or "").strip()
    return text, ""


def is_unit(text: str) -> bool:
    """True for a cell that holds a unit, or the label in front of a line of units."""
    text = text.strip().strip(BRACKETS)
    if text in DASHES or text.casefold() in LABELS:
        return True
    try:
        return len(text) <= LONGEST_UNIT and (text in RATIOS or bool(factor_and_dimension(text)[1]))
    except OffsetUnitError:
        return True
    except ValueError:
        return False


def headers_named(name: str, headers: Sequence[Header]) -> list[Header]:
    """The headers with a name: exact matches, else ignoring case and separators, and a prefix of them all."""
    exact = [one for one in headers if name in (one.text, one.name)]
    if exact:
        return exact
    groups = {one.name.partition(".")[0] for one in headers if one.name}
    inside = f"{min(groups)}.{name}" if len(groups) == 1 else name
    names = {normalized(name), normalized(inside)}
    return [one for one in headers if normalized(one.name) in names]


def normalized(name: str) -> str:
    """A name in lower case, with one sign between its words."""
    return WORD_BREAK.sub("_", name.strip().casefold())


class ColumnSource(NamedTuple):
    """What a user says of the column of a signal.

    Attributes:
        column: its name, with the unit that it is in where its header gives another or none; "" for the
            usual one.
        scale: of the signal per unit of the column, such as "0.25 V/mA"; "" where units convert.
        offset: of the signal where the column is 0, such as "-62.5 bar", or a number in its SI unit.
    """

    column: str = ""
    scale: str = ""
    offset: str | float = 0.0


class RecordColumn(NamedTuple):
    """A column of a record: the signal is ``factor`` times its numbers plus ``offset``."""

    signal: str  # what it holds
    header: Header  # as the file has it
    unit: str = ""  # of its numbers; "" where no one says it
    factor: Fraction = Fraction(1)  # SI units per unit of its numbers
    offset: float = 0.0  # in SI units

    def in_si(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Numbers of the column in SI units.

        Division by a whole number is correctly rounded where multiplication by its inverse is not.
        """
        with np.errstate(over="ignore"):  # what is too large is refused as not finite
            many = abs(self.factor) >= 1
            scaled = values * float(self.factor) if many else values / float(1 / self.factor)
            return scaled + self.offset if self.offset else scaled


Samples = Mapping[str, NDArray[np.float64]]  # by signal
Choose = Callable[[Sequence[Header], str], Sequence[RecordColumn]]  # from the headers, and where they stand


class RecordedColumns(NamedTuple):
    """The chosen columns of a file, all its headers, and the samples of those columns."""

    columns: Sequence[RecordColumn]
    headers: Sequence[Header]
    samples: Samples


def column_source(value: Any) -> ColumnSource:
    """What a name of a column, or a table ``{ column = "I [mA]", scale = "0.25 V/mA" }``, says."""
    if isinstance(value, str):
        return ColumnSource(value)
    if not isinstance(value, Mapping):
        raise ValueError('must be the name of a column, such as "v_piston [mm/s]"')
    for key, text in value.items():
        if key not in KEYS:
            raise ValueError(f"has the unknown key {short(key)}; it {one_of(str(key), KEYS)}")
        number = key == "offset" and isinstance(text, int | float) and not isinstance(text, bool)
        if not number and not isinstance(text, str):
            example = {"column": "I [mA]", "scale": "0.25 V/mA"}.get(key, "-62.5 bar")
            raise ValueError(f'has {key} = {short(text)}, which must be a string such as "{example}"')
    return ColumnSource(**value)


def choose_columns(
    headers: Sequence[Header],
    sources: Mapping[str, ColumnSource],
    signals: Mapping[str, tuple[Field, Sequence[str]]],
    where: tuple[str, str],
) -> list[RecordColumn]:
    columns = []
    for signal, (field, usual) in signals.items():
        source = sources.get(signal, ColumnSource())
        names = [source.column] if source.column else usual
        match = next(filter(None, (find_header(name, headers, where) for name in names)), None)
        if match is not None:
            header, unit = match
            try:
                columns.append(scaled_column(signal, field, header, unit, source))
            except ValueError as error:
                hint = "" if source.scale or source.offset else column_advice(signal, field, header)
                raise ScenarioError(*where, f"column {short(header.text)} {error}{hint}") from None
        elif source.column:
            name = name_and_unit(source.column)[0]
            problem = f"column {short(name)} for {signal} is missing; {column_choices(name, headers)}"
            raise ScenarioError(*where, problem)
    return columns


def find_header(name: str, headers: Sequence[Header], where: tuple[str, str]) -> tuple[Header, str] | None:
    """The header of a name, or of a name and a unit, and that unit; None if there is none."""
    matches, unit = headers_named(name, headers), ""
    if not matches:
        own, unit = name_and_unit(name)
        matches = headers_named(own, headers) if unit else []
    if len(matches) > 1:
        raise ScenarioError(*where, f"column {short(matches[0].name)} appears more than once")
    return (matches[0], unit) if matches else None


def scaled_column(signal: str, field: Field, header: Header, unit: str, source: ColumnSource) -> RecordColumn:
    if header.clock and field.unit == "s":
        return RecordColumn(signal, header, "s")
    unit = known_unit(unit or header.unit)
    factor = column_factor(source.scale, unit, field.unit)
    return RecordColumn(signal, header, unit, factor, column_offset(source.offset, field.unit))


def known_unit(unit: str) -> str:
    """A unit, in lower case where only that is one, as of Volts, Bar and PSI."""
    for text in (unit, unit.lower()):
        with suppress(ValueError):
            factor_and_dimension(text)
            return text
    return unit


def column_offset(offset: str | float, unit: str) -> float:
    """The offset of a signal in its SI unit."""
    if not isinstance(offset, str):
        return float(offset)
    try:
        return si_value(offset, unit)
    except ValueError as error:
        raise ValueError(f"has the offset {short(offset)}, which {error}") from None


def column_factor(scale: str, unit: str, si_unit: str) -> Fraction:
    """SI units of a signal per unit of its column."""
    if not scale:
        if not unit and si_unit:
            raise ValueError("has no unit")
        return unit_factor(unit, si_unit)
    try:
        number, scale_unit = number_and_unit(scale)
    except ValueError:
        raise ValueError(f"has the scale {short(scale)}, which must be such as '0.25 V/mA'") from None
    if not number:
        raise ValueError(f"has the scale {scale}, which must not be 0")
    numerator, slash, denominator = scale_unit.rpartition("/")
    product = f"({scale_unit}) ({unit})" if scale_unit and unit else scale_unit or unit
    cancels = slash and (not unit or denominator.strip(" ()") == unit)  # V/count of a column of counts, too
    products = [numerator, product] if cancels else [product]
    si_factor, si_dimension = factor_and_dimension(si_unit)
    for text in products:
        with suppress(ValueError):
            factor, dimension = factor_and_dimension(text)
            if dimension == si_dimension:
                return number * factor / si_factor
    raise ValueError(f"times {scale} does not convert to {si_unit}")


def column_advice(signal: str, field: Field, header: Header) -> str:
    """What to write where a column has no unit, or one of another dimension."""
    key = f"[identify.columns] {signal}"
    if not header.unit:
        return f'; write {key} = "{header.name} [{field.unit}]", or the unit that it is in'
    if (field.unit, header.unit) in FORCES:
        return f"; {scale_advice(field, header)}"
    scale = f'scale = "{scale_example(field, header)}"'
    return f'; write {key} = {{ column = "{header.text}", {scale} }}'


def scale_advice(field: Field, header: Header) -> str:
    """What may help with a column whose unit has another dimension than the signal."""
    force = FORCES.get((field.unit, header.unit))
    if force:
        return f"that is a mass, and the force is {force}"
    return f'add scale = "{scale_example(field, header)}"'


def scale_example(field: Field, header: Header) -> str:
    """The form of a scale that would do."""
    return "NUMBER " + "/".join(
        f"({one})" if set(one) & set("/ ") else one for one in (field.unit, header.unit)
    )


def column_choices(name: str, headers: Sequence[Header]) -> str:
    """Which columns there are, and which may be meant."""
    return f"it must be one of {first_names(headers)}{nearest(name, [one.name for one in headers])}"


def first_names(headers: Sequence[Header]) -> str:
    """The first of the columns, and how many more there are."""
    names = [one.text for one in headers if one.text]
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return f"{', '.join(names[:NAMED])}{more}"
