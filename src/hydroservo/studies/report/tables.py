"""The tables of a study's report: numbers in SI units, of which the page, LaTeX and CSV are printed."""

import math
from collections.abc import Iterable

from hydroservo.show import Cell, Column, Mark, Table
from hydroservo.show.table import Value
from hydroservo.studies.ablation import Ratio
from hydroservo.studies.report.findings import Findings

DIGITS = 3
ACTIVITY = Column("activity", "%/s", DIGITS)


def interval_columns(heading: str, unit: str = "", digits: int = DIGITS) -> list[Column]:
    """A number and the ends of its interval."""
    return [Column(f"{heading}{end}", unit, digits) for end in ("", " low", " high")]


def range_columns(heading: str, unit: str = "") -> list[Column]:
    """The least and the largest of some numbers."""
    return [Column(f"{heading} {end}", unit, digits=2) for end in ("from", "to")]


def count_columns(*headings: str) -> list[Column]:
    return [Column(heading, digits=DIGITS) for heading in headings]


def cells_of(values: Iterable[Value], mark: Mark | None = None) -> list[Cell]:
    """A row of a table whose columns have the units."""
    return [Cell(value, mark=mark) for value in values]


def interval_of(value: float, low: float, high: float) -> Ratio:
    """A number and its interval; nan throughout where there is no number."""
    return Ratio(value, low, high) if math.isfinite(value) else Ratio(*[math.nan] * 3)


def range_of(values: Iterable[float]) -> tuple[float, float]:
    """The least and the largest of some numbers; nan where there are none."""
    numbers = [value for value in values if not math.isnan(value)]
    return (min(numbers), max(numbers)) if numbers else (math.nan, math.nan)


def decibels(ratio: float) -> float:
    return 20.0 * math.log10(ratio)


def laws_in(found: Findings, cell: str) -> list[str]:
    """The laws of a cell, the one with the least error first, those that lose too many runs last."""
    standings, most = found.at.cells[cell].standings, found.verdicts.rules.most_lost

    def place(law: str) -> tuple[bool, float]:
        one = standings[law]
        return one.lost.value > most, math.inf if math.isnan(one.error) else one.error

    return sorted(standings, key=place)


def front_table(found: Findings) -> Table:
    """Each point of each front."""
    columns = [
        *(Column("cell"), Column("law"), Column("level"), ACTIVITY),
        *interval_columns("error", found.unit),
        *interval_columns("ratio"),
    ]
    points = [
        (cell, law, one)
        for cell, own in found.verdicts.fronts.items()
        for law, (some, _) in own.items()
        for one in some
    ]
    rows = [cells_of((cell, law, one.level, *one[:4], *one.ratio)) for cell, law, one in points]
    return Table(
        "fronts",
        columns,
        rows,
        "The fronts of all laws on test conditions.",
        "Level: the smallest at which these gains are taken. Ratio: of the error to that of "
        f"{found.reference} at its own activity.",
    )
