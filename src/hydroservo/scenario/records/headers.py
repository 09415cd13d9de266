"""Names and units of the columns of a file."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from hydroservo.scenario.units import OFFSET, factor_and_dimension

__all__ = ["Header", "header", "is_unit", "name_and_unit", "places_of"]

LONGEST_UNIT = 32  # characters
UNIT = re.compile(r"\s*(?:\[([^][]*)\]|\(((?:[^()]|\([^()]*\))*)\))$")  # at the end of a header
INDEX = re.compile(r"\S\[[0-9]+\]$")  # of a column of a matrix, as data[1]
WORD_BREAK = re.compile(r"[\s_-]+")
BRACKETS = " []()"
NO_UNIT = ("-", "--", "1")  # of a ratio
LABELS = ("unit", "units", "unit:", "units:")  # in front of a line of units


class Header(NamedTuple):
    """What a file says of a column.

    Attributes:
        text: as the file has it, such as "velocity [mm/s]".
        name: without the unit.
        unit: "" if none is given.
        clock: its cells are dates or times of day.
    """

    text: str
    name: str
    unit: str = ""
    clock: bool = False


def header(text: str, unit: str = "") -> Header:
    """The header that a text is, with a unit from elsewhere where it has none itself."""
    name, own = name_and_unit(text.strip())
    unit = own or unit.strip().strip(BRACKETS)
    unit = "1" if unit in NO_UNIT else "" if unit.casefold() in LABELS else unit
    return Header(text.strip() if own or not unit else f"{name} [{unit}]", name, unit)


def name_and_unit(text: str) -> tuple[str, str]:
    """The parts of "velocity [mm/s]", "Force (kN)" or "time / s"; no unit is ""."""
    match = UNIT.search(text)
    if match is not None and not INDEX.search(text):
        return text[: match.start()], (match[1] or match[2] or "").strip()
    name, stroke, unit = text.rpartition(" / ")
    return (name.strip(), unit.strip()) if stroke and is_unit(unit) else (text, "")


def is_unit(text: str) -> bool:
    """True for a cell that holds a unit, as many loggers write below the name of the column."""
    text = text.strip().strip(BRACKETS)
    if text in NO_UNIT[:2] or text.casefold() in LABELS:
        return True
    try:
        return len(text) <= LONGEST_UNIT and bool(factor_and_dimension(text)[1])
    except ValueError as error:
        return str(error).endswith(OFFSET)  # °C, dB


def places_of(name: str, headers: Sequence[Header]) -> list[int]:
    """Where columns have a name: as written, else in any case or inside the one structure of them all."""
    exact = [i for i, one in enumerate(headers) if name in (one.text, one.name)]
    if exact:
        return exact
    groups = {one.name.partition(".")[0] for one in headers if one.name}
    inside = f"{min(groups)}.{name}" if len(groups) == 1 else name
    names = {plain(name), plain(inside)}
    return [i for i, one in enumerate(headers) if plain(one.name) in names]


def plain(name: str) -> str:
    """A name in lower case, with one sign between its words."""
    return WORD_BREAK.sub("_", name.strip().casefold())
