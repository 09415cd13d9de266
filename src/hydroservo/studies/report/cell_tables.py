"""The tables of a cell: each law in it, beside the limits, its margins and its price on the target."""

import math

from hydroservo.show import Column, Mark, Table
from hydroservo.show.table import Value
from hydroservo.studies.pairs import Ratio, compared, ratio_between
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.sentences import interval
from hydroservo.studies.report.tables import (
    ACTIVITY,
    DIGITS,
    cells_of,
    count_columns,
    interval_columns,
    interval_of,
    laws_in,
    property_table,
)

LIMITS = (
    Column("law"),
    *interval_columns("over clairvoyant limit"),
    *count_columns("over causal limit", "lost runs", "runs"),
)


def cell_tables(found: Findings, name: str) -> list[Table]:
    """The tables of a cell at the level that is shown; of limits and properties where they are known."""
    tables = [cell_table(found, name)]
    cell = found.at.cells[name]
    if cell.limit.conditions:
        laws = [(law, cell.limit.laws[law]) for law in laws_in(found, name)]
        rows = [cells_of((law, *interval_of(*one[:3]), *one[3:])) for law, one in laws]
        tables.append(Table(f"limits-{name}", LIMITS, rows, f"{found.where(name)}. Errors over the limits."))
    if cell.properties:
        tables.append(property_table(found, name))
    return tables


def cell_table(found: Findings, name: str) -> Table:
    """Each law of a cell, the best one first."""
    best = found.at.cells[name].best
    marks = {**dict.fromkeys(best.ties, Mark.GOOD), best.law: Mark.BEST}
    return Table(
        f"cell-{name}",
        cell_columns(found),
        [cells_of(cell_row(found, name, law), marks.get(law)) for law in laws_in(found, name)],
        f"{found.where(name)}. {winner(found, name)}.",
        best="law; verdicts say which tie with it",
    )


def cell_columns(found: Findings) -> list[Column]:
    return [
        *(Column("law"), Column("verdict")),
        *interval_columns("error", found.unit),
        *count_columns("over best", "alone low", "alone high"),
        Column("Holm's chance", digits=2),
        Column("tail", found.unit, DIGITS),
        *interval_columns("lost runs", "%", digits=2),
        *(ACTIVITY, Column("hunting", "%", digits=2), Column("survives")),
        *(Column("sensors"), Column("rank")),
    ]


def cell_row(found: Findings, name: str, law: str) -> list[Value]:
    """The numbers of one law in one cell."""
    cell = found.at.cells[name]
    one, lost = cell.standings[law], cell.standings[law].lost
    return [
        *(law, verdict(found, name, law)),
        *interval_of(one.error, one.error_low, one.error_high),
        *beside_best(found, name, law),
        one.tail,
        *(100.0 * share for share in (lost.value, lost.low, lost.high)),
        *(one.activity, 100.0 * one.hunting, one.survived),
        *(str(found.manifest["laws"][law]["class"]), cell.ranks[law] if cell.best.law else math.nan),
    ]


def beside_best(found: Findings, name: str, law: str) -> list[float]:
    """A law's error over that of the best one, its interval, and the chance that the verdict is by."""
    cell = found.at.cells[name]
    if not cell.best.law or law == cell.best.law:
        return [math.nan] * 4
    pair = compared(cell.pairs, law, cell.best.law)
    chance = pair.lost_chance if pair.by == "lost runs" else pair.chance
    return [*interval_of(*ratio_between(cell.pairs, law, cell.best.law)), chance]


def verdict(found: Findings, name: str, law: str) -> str:
    """How a law stands to the best one of the cell."""
    best = found.at.cells[name].best
    if law == best.law:
        return "best"
    if found.at.cells[name].standings[law].lost.value > found.verdicts.rules.most_lost:
        return "out"
    by = compared(found.at.cells[name].pairs, law, best.law).by
    return {"error": "behind", "lost runs": "loses more"}.get(by, "tie")


def winner(found: Findings, name: str) -> str:
    """Who wins a cell, in words."""
    best = found.at.cells[name].best
    if not best.law:
        return "No law stays stable"
    margin = Ratio(best.margin, best.margin_low, best.margin_high)
    following = f"; {best.next_family} has {interval(margin)} times its error" if best.next_family else ""
    if best.state == "tie":
        return f"Tie between {', '.join(best.families)}; {best.law} is best{following}"
    return f"{best.law} wins{following}"
