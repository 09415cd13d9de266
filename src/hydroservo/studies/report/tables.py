"""The rows of the report's tables."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import NamedTuple

from hydroservo.formatting import NONE, common_unit, number
from hydroservo.studies.ablation import Ratio
from hydroservo.studies.cell_verdict import CellVerdict
from hydroservo.studies.losses import Share
from hydroservo.studies.multiples import CellLimit
from hydroservo.studies.pairs import compared, ratio_between
from hydroservo.studies.report.commands import Repeat
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.property_tables import KINDS, kind_of, operations, taken
from hydroservo.studies.report.sentences import interval, listed

Row = dict[str, str]
Again = Mapping[tuple[str, str], Repeat]  # by cell and law


class CellTable(NamedTuple):
    """All numbers of a cell at the level that is shown.

    Attributes:
        name: of the cell.
        where: its levels in words.
        best: who wins, in words.
        unit: of the errors below.
        rows: a law each, the best first.
    """

    name: str
    where: str
    best: str
    unit: str
    rows: list[Row]


def law_rows(found: Findings) -> list[Row]:
    """Each law over all cells at the level that is shown, those with the least error first."""
    laws = found.manifest["laws"]
    order = sorted(laws, key=lambda law: (math.isnan(found.to_reference(law).value), found.to_reference(law)))
    return [law_row(found, law) for law in order]


def law_row(found: Findings, law: str) -> Row:
    about, cells = found.manifest["laws"][law], found.at.cells.values()
    own = [cell for cell in cells if law in cell.standings]
    states = Counter(state_in(cell, law) for cell in own)
    kinds = {f"kind-{k}": kind_ratio(found, law, k) for k in range(len(found.manifest["kinds"]))}
    return {
        "law": law,
        "sensors": str(about["class"]),
        "gains": str(about.get("gains", NONE)),
        "ratio": with_interval(found.to_reference(law)) if own else NONE,
        **(kinds if len(kinds) > 1 else {}),
        "best": str(states["best"]),
        "tie": str(states["tie"]),
        "behind": str(states["behind"]),
        "out": str(states["out"]),
        "cannot": str(len(found.verdicts.activity) - len(own)),
        "lost": found.percent_lost(law),
        "activity": activity_range(found, law),
        "hunting": hunting(own, law),
        "margins": margin_range(own, law),
        "operations": operations(found, law),
        "bytes": taken(found, law),
    }


def state_in(cell: CellVerdict, law: str) -> str:
    """How a law stands in a cell: best alone, tie with the best, behind it, or out."""
    if law in cell.best.ties:
        return "best" if cell.best.ties == [law] else "tie"
    return "out" if math.isinf(cell.regret[law]) or not cell.best.law else "behind"


def kind_ratio(found: Findings, law: str, kind: int) -> str:
    """A law's error over that of the reference at its own activity, under one kind of conditions."""
    ratios = [cell.kinds[law][kind] for cell in found.at.cells.values() if law in cell.kinds]
    logs = [math.log(one) if one > 0.0 else math.nan for one in ratios]
    if len(logs) < len(found.verdicts.activity) or any(map(math.isnan, logs)):
        return NONE
    return number(math.exp(fmean(logs)), 3)


def activity_range(found: Findings, law: str) -> str:
    """A law's command activity over that of the reference at its own, from the least to the largest cell."""
    ratios = []
    for name, cell in found.at.cells.items():
        own = cell.standings.get(law)
        base = found.reference_standing(name)
        if own and base.activity > 0.0 and not math.isnan(own.activity):
            ratios.append(own.activity / base.activity)
    return ends_of(ratios, 2)


def hunting(cells: Sequence[CellVerdict], law: str) -> str:
    """The share of test runs whose command oscillates for good, over cells."""
    shares = [100.0 * cell.standings[law].hunting for cell in cells]
    return ends_of([one for one in shares if not math.isnan(one)], 2)


def margin_range(cells: Sequence[CellVerdict], law: str) -> str:
    """The largest sensitivity peaks over cells [dB], and in how many there is none."""
    known = [cell.properties[law].margins for cell in cells if law in cell.properties]
    peaks = [20.0 * math.log10(one.sensitivity_peak) for one in known if one.stable]
    others = Counter(KINDS[kind_of(one)] for one in known if not one.stable)
    parts = [f"{text} in {count}" for text, count in others.items()]
    return "; ".join([*([ends_of(peaks, 2)] if peaks else []), *parts]) or NONE


def ends_of(values: Sequence[float], digits: int) -> str:
    """The least and the largest of some numbers."""
    ends = dict.fromkeys(number(one, digits) for one in (min(values), max(values))) if values else [NONE]
    return " to ".join(ends)


def cell_tables(found: Findings, again: Again) -> list[CellTable]:
    """A table for each cell, in the manifest's order."""
    cells = [name for name in found.manifest["cells"] if name in found.at.cells]
    return [cell_table(found, name, again) for name in cells]


def cell_table(found: Findings, name: str, again: Again) -> CellTable:
    cell = found.at.cells[name]
    most = found.verdicts.rules.most_lost

    def place(law: str) -> tuple[bool, float]:
        one = cell.standings[law]
        return one.lost.value > most, math.inf if math.isnan(one.error) else one.error

    unit, factor = common_unit((one.error for one in cell.standings.values()), found.unit)
    rows = [
        {"law": law, **standing(found, name, law, factor), **repeat(again.get((name, law)), factor)}
        for law in sorted(cell.standings, key=place)
    ]
    return CellTable(name, found.where(name), winner(found, name), unit, rows)


def repeat(one: Repeat | None, factor: float) -> Row:
    """The command that repeats a number, and the number."""
    if one is None:
        return {"command": "", "condition": "", "again": ""}
    again = "lost" if math.isinf(one.error) else number(factor * one.error, 5)
    return {"command": one.command, "condition": str(one.condition), "again": again}


def standing(found: Findings, name: str, law: str, factor: float) -> Row:
    """The numbers of one law in one cell."""
    cell = found.at.cells[name]
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
        "hunting": NONE if math.isnan(one.hunting) else number(100.0 * one.hunting, 2),
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
            "cell at a level",
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
            "activity",
            "the command's total variation in percent of its range a second, geometric mean over conditions",
        ),
        (
            "own activity",
            f"of {found.reference}: that of the calmest of its gains whose error on validation is at most "
            f"{rules.margin:g} times its least",
        ),
        (
            "gains",
            "fronts searched on train conditions; at each level, of the points calm enough on validation, "
            "the one that loses the fewest runs and of these has the least error",
        ),
        ("seed of the bootstrap", f"{rules.seed}, {rules.resamples:,} draws, for shares of factors"),
    ]
    return [*rows, *((name, text) for name, text in study_size(found) if text)]


def study_size(found: Findings) -> list[tuple[str, str]]:
    """How much the study asked, as far as the manifest says."""
    conditions, search = found.manifest.get("conditions", {}), found.manifest.get("search", {})
    counts = [
        f"{conditions[split]} {split}" for split in ("train", "validation", "test") if split in conditions
    ]
    stress = ", ".join(f"{scale:g}" for scale in conditions.get("stress", ()))
    of_limits = found.manifest.get("limits", {}).get("conditions", 0)
    levels = ", ".join(f"{one:g}" for one in search.get("levels", ()))
    searches = f"at most {search['candidates']:,} candidates" if "candidates" in search else ""
    seeds = f"{search['seeds']} of each law" if search.get("seeds", 1) > 1 else "one of each law"
    return [
        ("conditions", f"{listed(counts)} in each cell" if counts else ""),
        ("kinds of conditions", ", ".join(map(str, found.manifest.get("kinds", ())))),
        ("stress", f"{stress} times the nominal uncertainty" if stress else ""),
        ("limits", f"of the first {of_limits} test conditions of each cell" if of_limits else ""),
        ("searches", f"{seeds}, {searches}" if searches else ""),
        ("levels of activity", f"{levels} times that of {found.reference}" if levels else ""),
    ]
