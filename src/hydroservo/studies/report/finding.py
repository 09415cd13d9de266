"""What a study says: the error of each law at equal activity of its command."""

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from hydroservo.core.formatting import number
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.studies.cell_verdict import CellVerdict
from hydroservo.studies.law_standing import LawStanding
from hydroservo.studies.report.sentences import lead_sentence
from hydroservo.studies.report.view import StudyView, fronts_caption, study_view

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.studies.study import StudyResult

ByLevel = Sequence[CellVerdict | None]  # of a cell, at each level; None where no law is so calm


def study_finding(studied: "StudyResult") -> Finding:
    """What a study says."""
    found = study_view(studied.manifest, studied.verdicts)
    title = str(studied.manifest["title"])
    has_fronts = any(one.points for own in found.verdicts.fronts.values() for one in own.values())
    return Finding(
        title,
        [
            Line(lead_sentence(found._replace(level=level)))
            for level in dict.fromkeys([found.level, *found.verdicts.levels])
        ],
        [],
        [activity_table(found, cell) for cell in found.verdicts.activity],
        [Picture("fronts", fronts_caption(found), partial(draw_fronts, found))] if has_fronts else [],
        {"title": title, **found.verdicts.as_dict()},
    )


def draw_fronts(found: StudyView) -> "Plot":
    from hydroservo.studies.report.pictures import fronts_picture

    return fronts_picture(found)


def activity_table(found: StudyView, cell: str) -> Table:
    """The laws of a cell at each level of activity, the one with the least error first."""
    activity, levels = found.verdicts.activity[cell], found.verdicts.levels
    columns = [
        Column("law"),
        *(
            Column(f"\N{LESS-THAN OR EQUAL TO} {number(float(level) * activity)} %/s", digits=3)
            for level in levels
        ),
        *(UNIT, Column("lost runs at most", "%", digits=2)),
    ]
    verdicts = [level.cells.get(cell) for level in levels.values()]
    standings = {law: standings_of(verdicts, law) for one in verdicts if one for law in one.standings}
    return Table(
        f"activity-{cell}",
        columns,
        [
            [
                Cell(law),
                *(error_cell(verdict, law, found.unit) for verdict in verdicts),
                *(Cell(), Cell(100.0 * max(one.lost.value for one in standings[law]))),
            ]
            for law in sorted(standings, key=lambda law: least_error(standings[law]))
        ],
        f"{found.where(cell)}: {found.metric} by activity of the command.",
        f"Numbers: {found.metric} where the command's activity is at most the heading's.",
        "law, and those that tie with it",
    )


def standings_of(verdicts: ByLevel, law: str) -> list[LawStanding]:
    """How a law stands at each level at which it is."""
    return [one.standings[law] for one in verdicts if one and law in one.standings]


def least_error(standings: Sequence[LawStanding]) -> float:
    return min(math.inf if math.isnan(one.error) else one.error for one in standings)


def error_cell(verdict: CellVerdict | None, law: str, unit: str) -> Cell:
    if verdict is None or law not in verdict.standings:
        return Cell(math.nan, unit)
    error = verdict.standings[law].error
    if math.isnan(error):
        return Cell("lost", mark=Mark.BAD)
    return Cell(error, unit, Mark.BEST if law in verdict.best.ties else None)
