"""A study as its report reads it: what was asked, what was found, and in which words."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hydroservo.core.formatting import number
from hydroservo.figures.studies.grid import GridAxis, GridLevel, MapGrid
from hydroservo.studies.law_pairs import ErrorRatio, ratio_over_cells
from hydroservo.studies.law_standing import LawStanding
from hydroservo.studies.trials import Rules
from hydroservo.studies.verdicts import LevelVerdict, Verdicts

ACTIVITY = "activity over the reference's"  # an axis that no study's axis is named like
UNKNOWN = ErrorRatio(math.nan, 0.0, math.inf)


class StudyView(NamedTuple):
    """A study as its report reads it."""

    manifest: Mapping[str, Any]  # what ``study.json`` holds
    verdicts: Verdicts  # what was found
    grid: MapGrid  # the cells and their axes
    cell: str  # the one that is shown where there is room for one
    level: str  # the level of activity that is shown where there is room for one

    @property
    def at(self) -> LevelVerdict:
        """What was found at the level that is shown."""
        return self.verdicts.levels[self.level]

    @property
    def reference(self) -> str:
        """The law that others are held against."""
        return str(self.manifest["reference"])

    @property
    def laws(self) -> dict[str, Mapping[str, Any]]:
        """What the manifest says of each law that lacks nothing."""
        return {name: law for name, law in self.manifest["laws"].items() if not law.get("without")}

    @property
    def families(self) -> list[str]:
        """In the order that gives them their colours."""
        return sorted({str(law["family"]) for law in self.manifest["laws"].values()})

    @property
    def metric(self) -> str:
        """What the error is, in words."""
        return str(self.manifest["metric"]).replace("_", " ")

    @property
    def unit(self) -> str:
        """The SI unit of the error."""
        return str(self.manifest["unit"])

    def to_reference(self, law: str) -> ErrorRatio:
        """A law's error over that of the reference at its own activity, geometric mean over cells.

        It is nan unless the law has a ratio in every cell.
        """
        cells = self.at.cells
        ratios = {name: cell.to_own[law] for name, cell in cells.items() if law in cell.to_own}
        if len(ratios) < len(self.verdicts.activity) or any(math.isnan(one.value) for one in ratios.values()):
            return UNKNOWN
        return ratio_over_cells(ratios, self.verdicts.rules.confidence)

    def reference_standing(self, cell: str) -> LawStanding:
        """How the reference stands in a cell at its own activity."""
        return self.verdicts.levels["1"].cells[cell].standings[self.reference]

    def lost(self, law: str) -> float:
        """The share of test runs that a law loses in the cells with a best law; nan without any."""
        lived = [cell.standings for cell in self.at.cells.values() if cell.best.law]
        own = [standings[law] for standings in lived if law in standings]
        runs = sum(one.conditions for one in own)
        return sum(one.lost.lost for one in own) / runs if runs else math.nan

    def rows(self) -> dict[str, list[str]]:
        """The laws that are there with several observers, by what they are without one."""
        rows: dict[str, list[str]] = {}
        for name, law in self.laws.items():
            alone = law.get("stem") or " ".join(str(law[key]) for key in ("family", "wrapper") if law[key])
            rows.setdefault(str(alone), []).append(name)
        several = {row: {str(self.laws[law]["observer"]) for law in laws} for row, laws in rows.items()}
        return {row: laws for row, laws in rows.items() if len(several[row]) > 1}

    def where(self, cell: str) -> str:
        """A cell in words, such as ``sample period = 0.05, noise = 2``."""
        levels = self.grid.cells[cell]
        names = {axis.name: {level.name: level.label for level in axis.levels} for axis in self.grid.axes}
        parts = [f"{axis.label} = {names[axis.name][levels[axis.name]]}" for axis in self.grid.axes]
        return ", ".join(parts) or cell


def study_view(manifest: Mapping[str, Any], verdicts: Verdicts) -> StudyView:
    """A study as its report reads it.

    Returns:
        With the reference's own activity as the level shown, and the first cell with a best law there.
    """
    cells = verdicts.levels["1"].cells
    stable = [name for name, one in cells.items() if one.best.law]
    return StudyView(manifest, verdicts, grid_of(manifest), [*stable, *cells][0], "1")


def grid_of(manifest: Mapping[str, Any]) -> MapGrid:
    """The cells of a manifest and their axes.

    ``axes`` is a list of names, or of tables with ``name`` and, where they have them, ``label`` and
    ``levels``: each of these with ``name``, ``label`` and ``value``, in order. What is left out is taken from
    the cells, as they come.
    """
    cells = {
        name: {axis: level_key(level) for axis, level in own.items()}
        for name, own in manifest["cells"].items()
    }
    found = {axis: None for own in cells.values() for axis in own}
    about = manifest.get("axes") or list(found)
    return MapGrid(
        [grid_axis(one if isinstance(one, Mapping) else {"name": one}, cells) for one in about], cells
    )


def grid_with_levels(found: StudyView) -> MapGrid:
    """The cells at each level of activity: the first axis is the activity's."""
    levels = [GridLevel(name, name) for name in found.verdicts.levels]
    activity = GridAxis(ACTIVITY, f"activity over {found.reference}'s", levels)
    cells = {
        cell_at(cell, level.name): {ACTIVITY: level.name, **own}
        for level in levels
        for cell, own in found.grid.cells.items()
    }
    return MapGrid([activity, *found.grid.axes], cells)


def cell_at(cell: str, level: str) -> str:
    """The name of a cell at a level."""
    return f"{cell} {level}"


def grid_axis(about: Mapping[str, Any], cells: Mapping[str, Mapping[str, str]]) -> GridAxis:
    name = str(about["name"])
    met = list(dict.fromkeys(own[name] for own in cells.values()))
    declared = {level_key(level["name"]): level for level in about.get("levels", ())}
    order = [level for level in declared if level in met] + [level for level in met if level not in declared]
    levels = [GridLevel(level, level_label(level, declared.get(level, {}))) for level in order]
    return GridAxis(name, str(about.get("label", name)), levels)


def level_label(level: str, about: Mapping[str, Any]) -> str:
    """A level as axes show it: its label, else its value in a group without dimension, else its name."""
    if "label" in about:
        return str(about["label"])
    return number(float(about["value"])) if "value" in about else level


def level_key(level: object) -> str:
    return f"{level:g}" if isinstance(level, float) else str(level)


def is_sure(ratio: ErrorRatio, rules: Rules) -> bool:
    """Whether a ratio is no tie: its interval leaves 1 out, and it is further from 1 than the margin."""
    return not ratio.low <= 1.0 <= ratio.high and not 1.0 / rules.margin < ratio.value < rules.margin


def fronts_caption(found: StudyView) -> str:
    return (
        "What error costs in command activity: the fronts of all laws in each cell, on test conditions; "
        "errors far above the reference's are cut off. Both axes are over "
        f"{found.reference} at its own activity: the calmest of its gains that tie with its least error. The "
        "heading gives both. Bands are intervals of the ratio on the same conditions."
    )


def map_caption(found: StudyView) -> str:
    return (
        "Who wins where, and at what activity. A cell is a combination of conditions; its colour is the "
        "family of the best law on the test conditions, of those that are calm enough, the stronger the "
        "further the best law of any other family is behind. Grey is a tie, and the strip says between which "
        "families; the sign is the observer of the best law. Hatched: every law loses more than "
        f"{percent(found.verdicts.rules.most_lost)} of its runs. Empty: no law is so calm."
    )


def factorial_caption(found: StudyView) -> str:
    return (
        f"Law by observer, {level_text(found)}: the error of each pair over that of {found.reference}, with "
        "its interval over cells and its lost runs. Right: how much of what errors differ by within cells "
        "each factor explains beyond the others; the rest is interaction, and what the combinations tried "
        "cannot tell apart."
    )


def parts_caption(found: StudyView) -> str:
    return (
        f"What each part is worth, {level_text(found)}: the error of the law without it over that of the law "
        "with it, all cells. Right: in how many cells the part is needed, makes no difference that can be "
        "told, or does harm."
    )


def target_caption(found: StudyView) -> str:
    return (
        f"What error costs on the target, in the cell {found.where(found.cell)}, {level_text(found)}: error "
        "against the operations with real numbers that a sample takes at most. The line is the least error "
        "for so many. Hollow marks have no margins: the loop switches, rises without bound or does not "
        "settle about any operating point looked at, or is unstable about one."
    )


def limit_caption(found: StudyView) -> str:
    return (
        f"How much is left to gain, in the cell {found.where(found.cell)}, {level_text(found)}: error over "
        "the least that any command could leave that knows the future, geometric mean over the test "
        "conditions whose limits were sought; up to the grey line, the least of one that does not. Lines: "
        "intervals over conditions."
    )


def level_text(found: StudyView) -> str:
    """The level that is shown, in words."""
    if found.level == "1":
        return f"at {found.reference}'s own activity"
    return f"at {found.level} times {found.reference}'s activity"


def percent(share: float) -> str:
    return f"{100.0 * share:g} %"


CAPTIONS: Mapping[str, Callable[[StudyView], str]] = {
    "fronts": fronts_caption,
    "map": map_caption,
    "factorial": factorial_caption,
    "parts": parts_caption,
    "target": target_caption,
    "limit": limit_caption,
}


def interval_text(ratio: ErrorRatio) -> str:
    """A ratio with its interval, such as ``0.83 [0.76, 0.90]``."""
    return f"{number(ratio.value)} [{number(ratio.low)}, {number(ratio.high)}]"
