"""What an audit says."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.audits.verdicts import verdicts
from hydroservo.formatting import counted
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.assumptions import Assumption
    from hydroservo.audits.audited import Asked, Audit
    from hydroservo.audits.sustained import Sustained
    from hydroservo.figures.style import Plot

COLUMNS = (
    Column("block"),
    Column("it assumes that"),
    *(Column("value"), Column("bound"), UNIT),
    Column("margin", digits=3),
    Column("verdict"),
    Column("worst at", "s"),
)
VERDICTS = {
    True: Cell("holds", mark=Mark.GOOD),
    False: Cell("fails", mark=Mark.BAD),
    None: Cell("cannot be told", mark=Mark.DOUBTFUL),
}
NOTE = "Worst at: the instant of the run on which it was measured."
CAPTION = "The factor by which each assumption holds; below 1 it fails. At an edge: beyond the axis."


def audit_finding(audit: "Audit", scenario: str = "") -> Finding:
    """What an audit says.

    Args:
        audit: what ``audit`` returned.
        scenario: its name, if it has one.
    """
    margins = [one for one in audit.assumptions() if one.holds is not None]
    rows = [row for asked in audit.asked for row in rows_of(asked)]
    return Finding(
        title_of("Audit", scenario),
        [count_line([one.holds for one in audit.assumptions()]), *verdicts(audit)],
        [],
        [Table("assumptions", COLUMNS, rows, "What the law assumes of its loop.", NOTE)],
        [Picture("margins", CAPTION, lambda: drawn(margins))] if margins else [],
        numbers_of(audit, scenario),
        origins=[origin_of_loop(scenario, audit.loop)] if audit.loop else [],
    )


def drawn(margins: "Sequence[Assumption]") -> "Plot":
    from hydroservo.figures.margins import plot_margins

    return plot_margins(margins)


def count_line(verdicts: Sequence[bool | None]) -> Line:
    """How many assumptions hold and how many cannot be told."""
    if not verdicts:
        return Line("The law does not say what it assumes, or assumes nothing here.")
    untold = verdicts.count(None)
    rest = f"; {untold} cannot be told" if untold else ""
    true, every = verdicts.count(True), counted(len(verdicts), "assumption")
    return Line(f"{true} of {every} hold{'s' if true == 1 else ''}{rest}.")


def rows_of(asked: "Asked") -> list[list[Cell]]:
    """A row for each assumption of a block; one that says why for a block without any."""
    if not asked.assumptions:
        why = "does not say what it assumes" if asked.assumptions is None else "assumes nothing here"
        return [[Cell(asked.block), Cell(why, mark=Mark.QUIET), *[Cell()] * (len(COLUMNS) - 2)]]
    return [
        [
            Cell(asked.block),
            Cell(one.meaning),
            *(Cell(one.value, one.unit), Cell(one.bound, one.unit), Cell()),
            Cell(one.margin),
            VERDICTS[one.holds],
            Cell(one.at if math.isfinite(one.at) else None, "s"),
        ]
        for one in asked.assumptions
    ]


def numbers_of(audit: "Audit", scenario: str) -> dict[str, Any]:
    """All numbers of an audit, in SI units."""
    oscillation = audit.oscillation
    return {
        "scenario": scenario,
        "holds": audit.holds,
        "diverged": audit.lost,
        "assumptions": [
            {"path": asked.path, "block": asked.block, **one._asdict(), "holds": one.holds}
            for asked in audit.asked
            for one in asked.assumptions or ()
        ],
        "silent": [{"path": one.path, "block": one.block} for one in audit.asked if one.assumptions is None],
        "chatter": None if audit.chatter is None else audit.chatter._asdict(),
        "no_forecast": audit.no_forecast,
        "oscillation": None if oscillation is None else numbers_of_oscillation(oscillation),
        "strain": None if audit.strain is None else audit.strain._asdict(),
    }


def numbers_of_oscillation(one: "Sustained") -> dict[str, Any]:
    """The oscillation of the run, and what ends it."""
    remains = [each._asdict() for each in one.remains]
    return {**one._asdict(), "causes": [each.cause for each in one.causes], "remains": remains}
