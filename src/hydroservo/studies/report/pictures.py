"""The pictures of a study, from what was found."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from hydroservo.figures.studies.fronts import FrontLine, FrontPanel, TargetPoint, plot_fronts, plot_target
from hydroservo.figures.studies.map import Winner, plot_map
from hydroservo.figures.studies.ratios import (
    Combination,
    Distance,
    FactorShare,
    RatioLine,
    plot_distance,
    plot_factorial,
    plot_forest,
)
from hydroservo.show import Picture
from hydroservo.studies.fronts import FrontPoint, on_front
from hydroservo.studies.report.tables import motion_kind
from hydroservo.studies.report.view import CAPTIONS, StudyView, cell_at, grid_with_levels, is_sure

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot

MOST = 6  # laws beside the reference whose fronts are told apart


def study_pictures(found: StudyView) -> list[Picture]:
    """Those that a study has something to show in."""
    at = found.at
    lived = any(cell.best.law for cell in at.cells.values())
    choices = {
        "fronts": (
            fronts_picture,
            any(one.points for own in found.verdicts.fronts.values() for one in own.values()),
        ),
        "map": (map_picture, True),
        "factorial": (factorial_picture, lived and bool(found.rows())),
        "parts": (parts_picture, bool(at.worths)),
        "target": (target_picture, bool(target_points(found))),
        "limit": (
            limit_picture,
            bool(at.cells[found.cell].best.law and at.cells[found.cell].limit.conditions),
        ),
    }
    return [
        Picture(name, CAPTIONS[name](found), partial(draw, found))
        for name, (draw, there) in choices.items()
        if there
    ]


def fronts_picture(found: StudyView, also: Sequence[str] = ()) -> "Plot":
    """The error of each law over its activity, in each cell."""
    panels = []
    for name in found.manifest["cells"]:
        own = found.verdicts.fronts.get(name, {})
        base = found.reference_standing(name)
        lines = [
            front_line(law, points, base.activity)
            for law, (points, _) in own.items()
            if law in found.laws and points
        ]
        panels.append(FrontPanel(name, base.error, base.activity, lines))
    levels = list(map(float, found.verdicts.levels))
    laws = list(dict.fromkeys([*highlighted_laws(found), *also]))
    return plot_fronts(panels, laws, found.reference, levels, found.unit)


def front_line(law: str, points: Sequence[FrontPoint], activity: float) -> FrontLine:
    """The points of a law that none of it beats, and those at which it is compared."""
    members = on_front([(one.error, one.activity) for one in points])
    front = [one for one, there in zip(points, members, strict=True) if there]
    taken = [(one.activity / activity, one.ratio.value) for one in points if not math.isnan(one.level)]
    return FrontLine(law, [one.activity / activity for one in front], [one.ratio for one in front], taken)


def highlighted_laws(found: StudyView) -> list[str]:
    """The laws whose fronts are told apart: the reference, and those that are best most often.

    Of laws that differ in their observer alone it is the best one.
    """
    verdicts = found.verdicts.levels.values()
    best = Counter(cell.best.law for level in verdicts for cell in level.cells.values() if cell.best.law)
    laws = [found.reference, *(law for law, _ in best.most_common() if law in found.laws)]
    stems = {str(found.laws[law].get("stem") or law): law for law in reversed(laws)}
    return [law for law in dict.fromkeys(laws) if law in stems.values()][: MOST + 1]


def map_picture(found: StudyView) -> "Plot":
    """Who wins in which cell at which level of activity."""
    laws = found.manifest["laws"]
    winners = []
    for level, verdict in found.verdicts.levels.items():
        for name, cell in verdict.cells.items():
            best = cell.best
            if not best.law:
                winners.append(Winner(cell_at(name, level), (), "", math.nan))
                continue
            own = str(laws[best.law]["family"])
            families = [own, *(family for family in best.families if family != own)]
            margin = best.margin if best.next_family else math.inf
            winners.append(Winner(cell_at(name, level), families, observer_of(laws[best.law]), margin))
    return plot_map(grid_with_levels(found), winners, found.families)


def factorial_picture(found: StudyView) -> "Plot":
    combinations = [
        Combination(row, observer_of(found.laws[law]) or "none", *found.to_reference(law), found.lost(law))
        for row, laws in found.rows().items()
        for law in laws
    ]
    effects = found.at.effects.items()
    shares = [FactorShare(name, *one[:3]) for name, one in effects if not math.isnan(one.share)]
    return plot_factorial(combinations, shares, f"error over that of {found.reference}, all cells")


def observer_of(law: Mapping[str, Any]) -> str:
    return str(law["observer"] or "").removesuffix("Observer")


def parts_picture(found: StudyView) -> "Plot":
    lines = [
        RatioLine(
            f"{one.whole} without {one.part}",
            *one.over_cells,
            is_sure(one.over_cells, found.verdicts.rules),
            f"{one.wins} / {one.ties} / {one.losses}",
        )
        for one in found.at.worths.values()
    ]
    lines.sort(key=lambda line: (math.isnan(line.value), -line.value))
    return plot_forest(
        lines, "error without the part over that with it", found.verdicts.rules.margin, "needed / tie / harm"
    )


def target_picture(found: StudyView) -> "Plot":
    return plot_target(target_points(found), found.families, found.metric, found.unit)


def target_points(found: StudyView) -> list[TargetPoint]:
    """The laws of the cell shown that run, and whose price on the target is known."""
    cell, most = found.at.cells[found.cell], found.verdicts.rules.most_lost
    points = []
    for law, one in cell.properties.items():
        standing, operations = cell.standings[law], one.target.operations
        if operations and standing.lost.value <= most:
            family = str(found.manifest["laws"][law]["family"])
            points.append(TargetPoint(law, family, standing.error, operations, motion_kind(one.margins)))
    return points


def limit_picture(found: StudyView) -> "Plot":
    cell = found.at.cells[found.cell]
    lines = []
    for law, one in cell.limit.laws.items():
        if law in found.laws:
            lost = cell.standings[law].lost.value > found.verdicts.rules.most_lost
            ratios = [math.inf] * 3 if lost else [one.clairvoyant, one.low, one.high]
            lines.append(Distance(law, str(found.laws[law]["family"]), *ratios))
    lines.sort(key=lambda line: (math.isnan(line.value), line.value))
    return plot_distance(lines, found.families, cell.limit.causal / cell.limit.clairvoyant)
