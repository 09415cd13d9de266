"""What a part says: its numbers with their sources, what follows from them, and its picture."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hydroservo.scenario.part_sheets import Part
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot


def part_finding(part: Part, name: str = "") -> Finding:
    """What a part says.

    Args:
        part: it.
        name: as it was asked for; its own if empty.
    """
    rows = [[Cell(one.key), Cell(one.value), Cell(one.source)] for one in part.numbers]
    columns = [Column("key"), Column("value"), Column("source")]
    results = [[Cell(one.meaning), Cell(one.value, one.unit), Cell()] for one in part.sheet.results]
    return Finding(
        name or part.name,
        list(part_lines(part)),
        [],
        [
            Table("numbers", columns, rows, "What its file says."),
            Table("results", [Column("what follows"), Column("value"), UNIT], results),
        ],
        [Picture("part", part.sheet.caption, lambda: draw_part(part))] if part.sheet.panels else [],
        part_numbers(part),
    )


def part_lines(part: Part) -> Iterator[Line]:
    """What a part is, where its numbers are from, and what its sheet assumes."""
    yield Line(part.role, f": {part.title}.")
    if part.source:
        yield Line("Source", f": {part.source}.")
    assumed = [f"{one.key} = {one.value}" for one in part.assumed if one.key.rpartition(".")[2] != "type"]
    if assumed:
        yield Line("Assumed for this sheet", f", not of the part: {', '.join(assumed)}.", Mark.DOUBTFUL)


def draw_part(part: Part) -> "Plot":
    from hydroservo.figures.part import plot_part

    return plot_part(part.sheet.panels)


def part_numbers(part: Part) -> dict[str, Any]:
    """All of a part, in SI units where it is computed."""
    return {
        "name": part.name,
        "title": part.title,
        "source": part.source,
        "role": part.role,
        "numbers": [one._asdict() for one in part.numbers],
        "assumed": {one.key: one.value for one in part.assumed},
        "results": [one._asdict() for one in part.sheet.results],
    }
