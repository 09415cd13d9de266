"""The rows of the report's tables."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from hydroservo.formatting import NONE, common_unit, number
from hydroservo.studies.ablation import Ratio
from hydroservo.studies.losses import Share
from hydroservo.studies.multiples import CellLimit
from hydroservo.studies.pairs import compared, ratio_between
from hydroservo.studies.report.commands import Repeat
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.property_tables import operations, taken
from hydroservo.studies.report.sentences import interval, listed

__all__ = ["CellTable", "cell_tables", "law_rows", "rule_rows"]

Row = dict[str, str]
Again = Mapping[tuple[str, str], Repeat]  # by cell and law


class CellTable(NamedTuple):
    """All numbers of a cell.

    Attributes:
        name: of the cell.
        where: its levels in words.
        budget: candidates that all laws were given.
        best: who wins, in words.
        unit: of the errors below.
        rows: a law each, the best first.
    """

    name: str
    where: str
    budget: int
    best: str
    unit: str
    rows: list[Row]


def law_rows(found: Findings) -> list[Row]:
    """Each law over all cells, those that are near the best most often first."""
    areas = found.verdicts.areas
    order = sorted(areas, key=lambda law: -areas[law].near_best if areas[law].cells else 1.0)
    return [law_row(found, law) for law in order]


def law_row(found: Findings, law: str) -> Row:
    about, area = found.manifest["laws"][law], found.verdicts.areas[law]
    ratio = found.to_reference(law)
    return {
        "law": law,
        "sensors": str(about["class"]),
        "gains": str(about.get("gains", NONE)),
        "near": f"{round(area.near_best * area.cells)} of {area.cells}" if area.cells else NONE,
        "out": str(round(area.lost * area.cells)) if area.cells else NONE,
        "largest": known(area.largest),
        "ratio": "1" if law == found.reference else with_interval(ratio),
        "lost": found.percent_lost(law),
        "activity": activity_range(found, law),
        "operations": operations(found, law),
        "bytes": taken(found, law),
    }


def activity_range(found: Findings, law: str) -> str:
    """A law's command activity over that of the reference, from the least to the largest over cells."""
    ratios = []
    for cell in found.verdicts.cells.values():
        own, other = cell.standings.get(law), cell.standings.get(found.reference)
        if own and other and other.activity > 0.0:
            ratios.append(own.activity / other.activity)
    ends = dict.fromkeys(number(ratio, 2) for ratio in (min(ratios), max(ratios))) if ratios else [NONE]
    return " to ".join(ends)


def cell_tables(found: Findings, again: Again) -> list[CellTable]:
    """A table for each cell, in the manifest's order."""
    cells = [name for name in found.manifest["cells"] if name in found.verdicts.cells]
    return [cell_table(found, name, again) for name in cells]


def cell_table(found: Findings, name: str, again: Again) -> CellTable:
    cell = found.verdicts.cells[name]
    most = found.verdicts.rules.most_lost

    def place(law: str) -> tuple[bool, float]:
        one = cell.standings[law]
        return one.lost.value > most, math.inf if math.isnan(one.error) else one.error

    unit, factor = common_unit((one.error for one in cell.standings.values()), found.unit)
    rows = [
        {"law": law, **standing(found, name, law, factor), **repeat(again.get((name, law)), factor)}
        for law in sorted(cell.standings, key=place)
    ]
    return CellTable(name, found.where(name), cell.budget, winner(found, name), unit, rows)


def repeat(one: Repeat | None, factor: float) -> Row:
    """The command that repeats a number, and the number."""
    if one is None:
        return {"command": "", "condition": "", "again": ""}
    again = "lost" if math.isinf(one.error) else number(factor * one.error, 5)
    return {"command": one.command, "condition": str(one.condition), "again": again}


def standing(found: Findings, name: str, law: str, factor: float) -> Row:
    """The numbers of one law in one cell."""
    cell = found.verdicts.cells[name]
    one = cell.standings[law]
    best = cell.best.law
    row = {
        "class": "best" if law == best else "tie" if law in cell.best.ties else "",
        "verdict": verdict(found, name, law),
        "error": NONE,
        "ratio": NONE,
        "chance": NONE,
        "tail": known(factor * one.tail),
        "lost": share(one.lost),
        "activity": known(one.activity),
        "survived": NONE if math.isnan(one.survived) else f"{one.survived:g}",
        "rank": f"{found.manifest['laws'][law]['class']} {cell.ranks[law] if best else NONE}",
        **beside_limits(cell.limit, law),
    }
    if math.isfinite(one.error):
        ends = [known(factor * end) for end in (one.error, one.error_low, one.error_high)]
        row["error"] = f"{ends[0]} [{ends[1]}, {ends[2]}]"
    if best and law != best:
        pair = compared(cell.pairs, law, best)
        row["ratio"] = with_interval(Ratio(*ratio_between(cell.pairs, law, best)))
        row["chance"] = chance(pair.lost_chance if pair.by == "lost runs" else pair.chance)
    return row


def beside_limits(limit: CellLimit, law: str) -> Row:
    """How many times the limits of the cell a law leaves; empty where there are none."""
    if not limit.conditions:
        return {"limit": "", "causal": ""}
    one = limit.laws[law]
    if math.isnan(one.clairvoyant):
        return {"limit": NONE, "causal": NONE}
    lost = f", {one.lost} of {one.runs} lost" if one.lost else ""
    ends = f"[{known(one.low)}, {known(one.high)}]"
    return {"limit": f"{known(one.clairvoyant)} {ends}{lost}", "causal": known(one.causal)}


def verdict(found: Findings, name: str, law: str) -> str:
    """How a law stands to the best one of the cell."""
    best = found.verdicts.cells[name].best
    if law == best.law:
        return "best"
    if found.verdicts.cells[name].standings[law].lost.value > found.verdicts.rules.most_lost:
        return "out"
    by = compared(found.verdicts.cells[name].pairs, law, best.law).by
    return {"error": "behind", "lost runs": "loses more"}.get(by, "tie")


def winner(found: Findings, name: str) -> str:
    """Who wins a cell, in words."""
    best = found.verdicts.cells[name].best
    if not best.law:
        return "No law stays stable"
    margin = Ratio(best.margin, best.margin_low, best.margin_high)
    following = f"; {best.next_family} has {interval(margin)} times its error" if best.next_family else ""
    if best.state == "tie":
        return f"Tie between {', '.join(best.families)}; {best.law} has the least error{following}"
    return f"{best.law} wins{following}"


def with_interval(ratio: Ratio) -> str:
    return NONE if math.isnan(ratio.value) else interval(ratio)


def share(lost: Share) -> str:
    """The share of lost runs with its interval, in percent."""
    value, low, high = (number(100.0 * one, 2) for one in (lost.value, lost.low, lost.high))
    return f"{value} [{low}, {high}]"


def chance(value: float) -> str:
    return "< 0.0001" if value < 1e-4 else f"{value:.2g}"


def known(value: float) -> str:
    return NONE if math.isnan(value) else number(value)


def rule_rows(found: Findings) -> list[tuple[str, str]]:
    """The rules of the comparison, and how much was asked."""
    rules = found.verdicts.rules
    percent = f"{100.0 * rules.confidence:g} %"
    rows = [
        (
            "intervals",
            f"{percent}, paired: all laws meet the same conditions; Holm's correction over all pairs of a "
            "cell",
        ),
        (
            "a tie",
            f"the interval holds 1 after the correction, or the ratio is nearer to 1 than {rules.margin:g}",
        ),
        (
            "lost runs",
            "a law that loses surely fewer runs wins, whatever the errors; errors are compared where both "
            "have runs",
        ),
        (
            "out of the running",
            f"a law that loses more than {100.0 * rules.most_lost:g} % of its test runs in a cell",
        ),
        (
            "gains",
            "searched on train conditions; the weight of activity chosen on validation; all numbers here "
            "are of test conditions",
        ),
        ("seed of the bootstrap", f"{rules.seed}, {rules.resamples:,} draws, for shares of factors"),
    ]
    return [*rows, *((name, text) for name, text in asked(found) if text)]


def asked(found: Findings) -> list[tuple[str, str]]:
    """How much the study asked, as far as the manifest says."""
    conditions, search = found.manifest.get("conditions", {}), found.manifest.get("search", {})
    counts = [
        f"{conditions[split]} {split}" for split in ("train", "validation", "test") if split in conditions
    ]
    stress = ", ".join(f"{scale:g}" for scale in conditions.get("stress", ()))
    of_limits = found.manifest.get("limits", {}).get("conditions", 0)
    texts = {name: listed([f"{one}" for one in search.get(name, ())]) for name in ("optimisers", "efforts")}
    seeds = f"{search['seeds']} seeds" if "seeds" in search else ""
    return [
        ("conditions", f"{listed(counts)} in each cell" if counts else ""),
        ("kinds of conditions", ", ".join(map(str, found.manifest.get("kinds", ())))),
        ("stress", f"{stress} times the nominal uncertainty" if stress else ""),
        ("limits", f"of the first {of_limits} test conditions of each cell" if of_limits else ""),
        ("searches", ", ".join(part for part in (texts["optimisers"], seeds) if part)),
        ("weights of activity", texts["efforts"]),
    ]
