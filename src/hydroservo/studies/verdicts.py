"""All that a study says: who wins where, by how much, and how sure that is."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.errors import HydroservoError
from hydroservo.studies.ablation import Ratio, Worth, over_cells, worths
from hydroservo.studies.cell_verdict import CellVerdict, cell_verdict
from hydroservo.studies.choice import chosen
from hydroservo.studies.columns import judged_columns
from hydroservo.studies.factors import Effect, effects
from hydroservo.studies.means import FACTORS, means_of
from hydroservo.studies.multiples import OF_LIMITS
from hydroservo.studies.plain import plain
from hydroservo.studies.properties import Properties
from hydroservo.studies.regret import Area, areas
from hydroservo.studies.rules import Rules, checked_rules
from hydroservo.studies.sensing import CLASSES
from hydroservo.studies.trials import Trials

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Verdicts", "judged"]

Laws = Mapping[str, Mapping[str, Any]]


class Verdicts(NamedTuple):
    """All that a study says.

    Attributes:
        rules: that it goes by.
        cells: of each cell.
        areas: over how much of the map each law is near the best.
        effects: of family, observer and wrapper, of laws that lack nothing.
        worths: of parts, by the name of the law that lacks one.
        prices: of sensors over all cells, such as ``"V over VP"``.
    """

    rules: Rules
    cells: dict[str, CellVerdict]
    areas: dict[str, Area]
    effects: dict[str, Effect]
    worths: dict[str, Worth]
    prices: dict[str, Ratio]

    def as_dict(self) -> dict[str, Any]:
        """The same as JSON has it; null where there is no number, or an infinite one."""
        found: dict[str, Any] = plain(self)
        return found


def judged(
    table: "pd.DataFrame",
    manifest: Mapping[str, Any],
    rules: Rules | None = None,
    limits: "pd.DataFrame | None" = None,
    properties: Mapping[str, Mapping[str, Properties]] | None = None,
) -> Verdicts:
    """What a study says, from the table of its runs.

    Args:
        table: a row a run, with the columns of a study's parts, in any order.
        manifest: what ``study.json`` holds; its ``laws`` are used.
        rules: of the comparison.
        limits: a row a condition whose limits were sought, with the columns
            :data:`~hydroservo.studies.multiples.OF_LIMITS`; None if there are none.
        properties: of the laws, by cell and law; None if nobody computed them.

    Raises:
        HydroservoError: the table or the manifest does not say what it must, or laws met different
            conditions.
        ParameterError: a rule is out of its range.
    """
    import pandas as pd

    rules = checked_rules(rules or Rules())
    runs = judged_columns(table)
    laws = checked_laws(manifest, {str(law) for law in runs["law"].unique()})
    choice = chosen(runs)
    limits = pd.DataFrame(columns=OF_LIMITS) if limits is None else limits
    properties = properties or {}
    cells: dict[str, CellVerdict] = {}
    trials: dict[str, dict[str, Trials]] = {}
    for name, own in runs.groupby("cell", observed=True):
        cells[str(name)], trials[str(name)] = cell_verdict(
            own, choice, laws, rules, limits, properties.get(str(name), {})
        )
    return Verdicts(
        rules=rules,
        cells=cells,
        areas=areas({name: one.regret for name, one in cells.items()}, rules),
        effects=effects(means_of(trials, laws, rules), laws, rules.confidence),
        worths=worths({name: one.pairs for name, one in cells.items()}, laws, rules.confidence),
        prices=prices_over(cells, rules),
    )


def checked_laws(manifest: Mapping[str, Any], used: set[str]) -> dict[str, dict[str, str]]:
    """What the manifest says of the laws that the table has.

    Raises:
        HydroservoError: it lacks one of them, or does not say what it is, or of which law it lacks a part, or
            has no such class of sensors.
    """
    found: dict[str, dict[str, str]] = {}
    for name in sorted(used):
        own = manifest.get("laws", {}).get(name)
        if own is None:
            raise HydroservoError(f"study.json: laws: no {name}, which the study's table has")
        lacking = [key for key in (*FACTORS, "class") if key not in own]
        if lacking:
            raise HydroservoError(f"study.json: laws.{name}: no {', '.join(lacking)}")
        if own["class"] not in CLASSES:
            allowed = f"must be one of {', '.join(CLASSES)}"
            raise HydroservoError(f"study.json: laws.{name}.class = {own['class']!r}: {allowed}")
        if own.get("without") and own.get("of") not in manifest["laws"]:
            raise HydroservoError(f"study.json: laws.{name}.of = {own.get('of')!r}: must be one of its laws")
        found[name] = {key: str(own.get(key) or "") for key in (*FACTORS, "class", "of", "without")}
    return found


def prices_over(cells: Mapping[str, CellVerdict], rules: Rules) -> dict[str, Ratio]:
    """The prices of sensors over all cells that have them."""
    found: dict[str, dict[str, tuple[float, float, float]]] = {}
    for cell, verdict in cells.items():
        for one in verdict.prices:
            ratio = (one.ratio, one.low, one.high)
            found.setdefault(f"{one.without} over {one.with_it}", {})[cell] = ratio
    return {name: over_cells(ratios, rules.confidence) for name, ratios in sorted(found.items())}
