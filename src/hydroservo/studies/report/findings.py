"""A study as its report reads it: what was asked, what was found, and in which words."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from hydroservo.errors import ParameterError
from hydroservo.figures.studies.grid import Axis, Grid, Level
from hydroservo.formatting import NONE, number
from hydroservo.nearest import one_of
from hydroservo.studies.ablation import Ratio, over_cells
from hydroservo.studies.pairs import ratio_between
from hydroservo.studies.rules import Rules
from hydroservo.studies.verdicts import Verdicts

__all__ = ["Findings", "findings", "grid_of"]


class Findings(NamedTuple):
    """A study as its report reads it.

    Attributes:
        manifest: what ``study.json`` holds.
        verdicts: what was found.
        grid: the cells and their axes.
        reference: the law that others are held against over all cells.
        cell: the one whose front and curves are shown.
    """

    manifest: Mapping[str, Any]
    verdicts: Verdicts
    grid: Grid
    reference: str
    cell: str

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

    def to_reference(self, law: str) -> Ratio:
        """A law's error over that of the reference, geometric mean over cells."""
        ratios = {
            name: ratio_between(cell.pairs, law, self.reference)
            for name, cell in self.verdicts.cells.items()
            if {law, self.reference} <= cell.standings.keys()
        }
        return over_cells(ratios, self.verdicts.rules.confidence)

    def lost(self, law: str) -> float:
        """The share of test runs that a law loses in the cells that any law masters; nan where it is in "
        "none."""
        lived = [cell.standings for cell in self.verdicts.cells.values() if cell.best.law]
        own = [standings[law] for standings in lived if law in standings]
        runs = sum(one.searches * one.conditions for one in own)
        return sum(one.lost.lost for one in own) / runs if runs else math.nan

    def percent_lost(self, law: str) -> str:
        """The same as it is read."""
        lost = self.lost(law)
        return NONE if math.isnan(lost) else f"{number(100.0 * lost, 2)} %"

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


def findings(
    manifest: Mapping[str, Any], verdicts: Verdicts, reference: str = "", cell: str = ""
) -> Findings:
    """A study as its report reads it.

    Args:
        manifest: what ``study.json`` holds.
        verdicts: what :func:`~hydroservo.studies.verdicts.judged` found.
        reference: a law; if empty the manifest's ``reference``, or the first of its whole laws.
        cell: one whose front and curves are shown; if empty the first in which any law stays.

    Raises:
        ParameterError: there is no such law, or no such cell.
    """
    whole = [name for name, law in manifest["laws"].items() if not law.get("without")]
    reference = reference or str(manifest.get("reference", "")) or whole[0]
    if reference not in manifest["laws"]:
        raise ParameterError("reference", reference, one_of(reference, manifest["laws"]))
    lived = [name for name, one in verdicts.cells.items() if one.best.law]
    cell = cell or [*lived, *verdicts.cells][0]
    if cell not in verdicts.cells:
        raise ParameterError("cell", cell, one_of(cell, verdicts.cells))
    return Findings(manifest, verdicts, grid_of(manifest), reference, cell)


def grid_of(manifest: Mapping[str, Any]) -> Grid:
    """The cells of a manifest and their axes.

    ``axes`` is a list of names, or of tables with ``name`` and, where they have them, ``label`` and
    ``levels``: each of these with ``name``, ``label`` and ``value``, in order. What is left out is taken from
    the cells, as they come.
    """
    cells = {
        name: {axis: as_text(level) for axis, level in own.items()} for name, own in manifest["cells"].items()
    }
    found = {axis: None for own in cells.values() for axis in own}
    about = manifest.get("axes") or list(found)
    return Grid([axis_of(one if isinstance(one, Mapping) else {"name": one}, cells) for one in about], cells)


def axis_of(about: Mapping[str, Any], cells: Mapping[str, Mapping[str, str]]) -> Axis:
    name = str(about["name"])
    met = list(dict.fromkeys(own[name] for own in cells.values()))
    declared = {as_text(level["name"]): level for level in about.get("levels", ())}
    order = [level for level in declared if level in met] + [level for level in met if level not in declared]
    levels = [Level(level, label_of(level, declared.get(level, {}))) for level in order]
    return Axis(name, str(about.get("label", name)), levels)


def label_of(level: str, about: Mapping[str, Any]) -> str:
    """A level as axes show it: its label, or else its value in a group without dimension, or else its "
    "name."""
    if "label" in about:
        return str(about["label"])
    return number(float(about["value"])) if "value" in about else level


def as_text(level: object) -> str:
    return f"{level:g}" if isinstance(level, float) else str(level)


def sure(ratio: Ratio, rules: Rules) -> bool:
    """Whether a ratio is no tie: its interval leaves 1 out, and it is further from 1 than the margin."""
    return not ratio.low <= 1.0 <= ratio.high and not 1.0 / rules.margin < ratio.value < rules.margin
