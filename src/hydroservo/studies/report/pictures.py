"""The pictures of a study, from what was found."""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.figures.studies.curves import BudgetCurve, plot_curves
from hydroservo.figures.studies.distance import Distance, plot_distance
from hydroservo.figures.studies.factorial import Combination, FactorShare, plot_factorial
from hydroservo.figures.studies.forest import RatioLine, plot_forest
from hydroservo.figures.studies.front import FrontPoint, plot_front
from hydroservo.figures.studies.map import Winner, plot_map
from hydroservo.figures.studies.regret import plot_regret
from hydroservo.figures.studies.target import TargetPoint, plot_target
from hydroservo.studies.report.captions import CAPTIONS
from hydroservo.studies.report.findings import Findings, sure
from hydroservo.studies.report.property_tables import kind_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Picture", "pictures", "the_map"]


class Picture(NamedTuple):
    """A picture that a study has.

    Attributes:
        name: of its files.
        caption: what it shows.
        draw: draws it.
    """

    name: str
    caption: str
    draw: "Callable[[Findings], Figure]"


def pictures(found: Findings) -> list[Picture]:
    """Those that a study has something to show in."""
    whole, verdicts = found.laws, found.verdicts
    shown = verdicts.cells[found.cell]
    lived = any(cell.best.law for cell in verdicts.cells.values())
    has = {
        "map": True,
        "regret": lived,
        "pairs": lived and len(whole) > 1,
        "factorial": lived and bool(found.rows()),
        "parts": bool(verdicts.worths),
        "front": any(math.isfinite(one.error) for one in shown.front),
        "target": bool(target_points(found)),
        "curves": any(
            len([one for one in stages if math.isfinite(one.error)]) > 1 for stages in shown.curves.values()
        ),
        "limit": bool(shown.best.law and shown.limit.conditions),
    }
    draws = {
        "map": the_map,
        "regret": regret,
        "pairs": pairs,
        "factorial": factorial,
        "parts": parts,
        "front": front,
        "target": target,
        "curves": curves,
        "limit": limit,
    }
    return [Picture(name, CAPTIONS[name](found), draws[name]) for name, there in has.items() if there]


def the_map(found: Findings) -> "Figure":
    """Who wins in which cell."""
    laws = found.manifest["laws"]
    winners = []
    for name, cell in found.verdicts.cells.items():
        best = cell.best
        if not best.law:
            winners.append(Winner(name, (), "", math.nan))
            continue
        own = str(laws[best.law]["family"])
        families = [own, *(family for family in best.families if family != own)]
        margin = best.margin if best.next_family else math.inf
        winners.append(Winner(name, families, observer_of(laws[best.law]), margin))
    return plot_map(found.grid, winners, found.families)


def regret(found: Findings) -> "Figure":
    cells = found.verdicts.cells
    ratios = {
        law: {name: cell.regret[law] for name, cell in cells.items() if law in cell.regret}
        for law in found.laws
    }
    return plot_regret(found.grid, ratios, found.verdicts.rules.near_best)


def pairs(found: Findings) -> "Figure":
    lines = []
    for law in found.laws:
        if law != found.reference:
            ratio = found.to_reference(law)
            lines.append(RatioLine(law, *ratio, sure(ratio, found.verdicts.rules), found.percent_lost(law)))
    lines.sort(key=lambda line: (math.isnan(line.value), line.value))
    label = f"error over that of {found.reference}, all cells"
    return plot_forest(lines, label, found.verdicts.rules.margin, "lost runs")


def factorial(found: Findings) -> "Figure":
    combinations = [
        Combination(row, observer_of(found.laws[law]) or "none", *found.to_reference(law), found.lost(law))
        for row, laws in found.rows().items()
        for law in laws
    ]
    effects = found.verdicts.effects.items()
    shares = [FactorShare(name, *one[:3]) for name, one in effects if not math.isnan(one.share)]
    return plot_factorial(combinations, shares, f"error over that of {found.reference}, all cells")


def observer_of(law: Mapping[str, Any]) -> str:
    """The observer of a law as a legend has it."""
    return str(law["observer"] or "").removesuffix("Observer")


def parts(found: Findings) -> "Figure":
    lines = [
        RatioLine(
            f"{one.whole} without {one.part}",
            *one.over_cells,
            sure(one.over_cells, found.verdicts.rules),
            f"{one.wins} / {one.ties} / {one.losses}",
        )
        for one in found.verdicts.worths.values()
    ]
    lines.sort(key=lambda line: (math.isnan(line.value), -line.value))
    return plot_forest(
        lines,
        "error without the part over that with it",
        found.verdicts.rules.margin,
        "needed / tie / harm",
    )


def front(found: Findings) -> "Figure":
    laws = found.manifest["laws"]
    points = [
        FrontPoint(one.law, str(laws[one.law]["family"]), one.error, one.activity, one.survived, one.front)
        for one in found.verdicts.cells[found.cell].front
        if math.isfinite(one.error) and one.activity > 0.0 and one.lost <= found.verdicts.rules.most_lost
    ]
    return plot_front(points, found.families, found.metric, found.unit)


def target(found: Findings) -> "Figure":
    return plot_target(target_points(found), found.families, found.metric, found.unit)


def target_points(found: Findings) -> list[TargetPoint]:
    """The laws of the cell shown that run, and whose price on the target is known."""
    cell, most = found.verdicts.cells[found.cell], found.verdicts.rules.most_lost
    points = []
    for law, one in cell.properties.items():
        standing, operations = cell.standings[law], one.target.operations
        if operations and standing.lost.value <= most:
            family = str(found.manifest["laws"][law]["family"])
            points.append(TargetPoint(law, family, standing.error, operations, kind_of(one.margins)))
    return points


def curves(found: Findings) -> "Figure":
    drawn = []
    for law, about in found.laws.items():
        stages = found.verdicts.cells[found.cell].curves.get(law, [])
        stages = [stage for stage in stages if math.isfinite(stage.error)]
        if stages:
            budgets = [stage.budget for stage in stages]
            columns = (
                [stage.error for stage in stages],
                [stage.low for stage in stages],
                [stage.high for stage in stages],
            )
            drawn.append(BudgetCurve(law, str(about["family"]), budgets, *columns))
    return plot_curves(drawn, found.families, f"{found.metric} on test", found.unit)


def limit(found: Findings) -> "Figure":
    cell = found.verdicts.cells[found.cell]
    lines = []
    for law, one in cell.limit.laws.items():
        if law in found.laws:
            lost = cell.standings[law].lost.value > found.verdicts.rules.most_lost
            ratios = [math.inf] * 3 if lost else [one.clairvoyant, one.low, one.high]
            lines.append(Distance(law, str(found.laws[law]["family"]), *ratios))
    lines.sort(key=lambda line: (math.isnan(line.value), line.value))
    return plot_distance(lines, found.families, cell.limit.causal / cell.limit.clairvoyant)
