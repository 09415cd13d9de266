"""Names and units of the columns of a file."""

import re
from collections.abc import Sequence
from typing import NamedTuple

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


class Header(NamedTuple):
    """What a file says of a column.

    Attributes:
        text: as the file has it, such as "velocity [mm/s]".
        name: without the unit.
        place: the number of the column, from 0 on.
        unit: "" if none is given.
        clock: its cells are dates or times of day.
    """

    text: str
    name: str
    place: int
    unit: str = ""
    clock: bool = False


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
