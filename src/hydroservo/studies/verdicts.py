"""All that a study says: who wins where, by how much, and how sure that is."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.core.errors import HydroservoError
from hydroservo.studies.cell_verdict import CLASSES, Area, CellVerdict, Comparison, cell_verdict, law_areas
from hydroservo.studies.factors import FACTORS, FactorEffect, cell_means, factor_effects
from hydroservo.studies.fronts import (
    LawFront,
    activities_of,
    choose_gains,
    front_points,
    fronts_of,
    level_name,
)
from hydroservo.studies.law_pairs import ErrorRatio, Worth, part_worths, ratio_over_cells
from hydroservo.studies.law_standing import OF_LIMITS
from hydroservo.studies.properties import Properties
from hydroservo.studies.trials import GAINS, Rules, Trials, checked_rules, judged_columns, trials_of

if TYPE_CHECKING:
    import pandas as pd

ManifestLaws = Mapping[str, Mapping[str, Any]]
PropertiesByCell = Mapping[str, Mapping[str, Properties]]
PropertiesByLevel = Mapping[str, PropertiesByCell]


class LevelVerdict(NamedTuple):
    """All that a study says at one level of activity.

    Attributes:
        cells: of each cell.
        areas: over how much of the map each law is near the best.
        effects: of family, observer and wrapper, of laws that lack nothing.
        worths: of parts, by the name of the law that lacks one.
        prices: of sensors over all cells, such as ``"V over VP"``.
    """

    cells: dict[str, CellVerdict]
    areas: dict[str, Area]
    effects: dict[str, FactorEffect]
    worths: dict[str, Worth]
    prices: dict[str, ErrorRatio]


class Verdicts(NamedTuple):
    """All that a study says.

    Attributes:
        rules: that it goes by.
        activity: of the reference in each cell, on validation: what levels are multiples of [%/s].
        levels: at each level of activity, by its multiple as text, such as ``"0.5"``.
        fronts: of each law, by cell and law.
    """

    rules: Rules
    activity: dict[str, float]
    levels: dict[str, LevelVerdict]
    fronts: dict[str, dict[str, LawFront]]

    def as_dict(self) -> dict[str, Any]:
        """The same as JSON has it; null where there is no number, or an infinite one."""
        found: dict[str, Any] = as_json_value(self)
        return found


def study_verdicts(
    table: "pd.DataFrame",
    manifest: Mapping[str, Any],
    rules: Rules | None = None,
    limits: "pd.DataFrame | None" = None,
    properties: PropertiesByLevel | None = None,
) -> Verdicts:
    """What a study says, from the table of its runs.

    Args:
        table: a row a run, with the columns of a study's parts, in any order.
        manifest: what ``study.json`` holds; its ``laws``, ``reference``, ``search.levels`` and ``kinds`` are
            used.
        rules: of the comparison.
        limits: a row a condition whose limits were sought, with the columns
            :data:`~hydroservo.studies.law_standing.OF_LIMITS`; None if there are none.
        properties: of the laws, by level, cell and law; None if nobody computed them.

    Raises:
        HydroservoError: the table or the manifest does not say what it must, or laws met different
            conditions.
        ParameterError: a rule is out of its range.
    """
    import pandas as pd

    rules = checked_rules(rules or Rules())
    runs = judged_columns(table)
    laws = checked_laws(manifest, {str(law) for law in runs["law"].unique()})
    reference, levels = str(manifest["reference"]), manifest["search"]["levels"]
    choice = choose_gains(runs, reference, levels, rules)
    limits = pd.DataFrame(columns=OF_LIMITS) if limits is None else limits
    tests, stress = (runs[runs["split"] == split].merge(choice, on=GAINS) for split in ("test", "stress"))
    check_tested(choice, tests)
    own = tests[(tests["law"] == reference) & (tests["level"] == 1.0)]
    bases = {str(cell): trials_of(one) for cell, one in own.groupby("cell", observed=True)}
    found = {}
    by = Comparison(laws, len(manifest["kinds"]), rules, limits)
    for level in levels:
        own_tests, own_stress = (runs[runs["level"] == level] for runs in (tests, stress))
        own_properties = (properties or {}).get(level_name(level), {})
        found[level_name(level)] = level_verdict(own_tests, own_stress, bases, by, own_properties)
    return Verdicts(
        rules=rules,
        activity=activities_of(front_points(runs, "validation"), reference, rules),
        levels=found,
        fronts=fronts_of(runs, choice, bases, rules),
    )


def level_verdict(
    tests: "pd.DataFrame",
    stress: "pd.DataFrame",
    bases: Mapping[str, Trials],
    by: Comparison,
    properties: PropertiesByCell,
) -> LevelVerdict:
    """What a study says at one level, from the runs there with the gains that validation chose."""
    cells: dict[str, CellVerdict] = {}
    trials: dict[str, dict[str, Trials]] = {}
    for key, own in tests.groupby("cell", observed=True):
        name = str(key)
        in_cell = by._replace(limits=by.limits[by.limits["cell"] == name])
        own_stress = stress[stress["cell"] == name]
        cells[name], trials[name] = cell_verdict(
            own, own_stress, bases[name], in_cell, properties.get(name, {})
        )
    laws, rules = by.laws, by.rules
    return LevelVerdict(
        cells=cells,
        areas=law_areas({name: one.regret for name, one in cells.items()}, rules),
        effects=factor_effects(cell_means(trials, laws, rules), laws, rules.confidence),
        worths=part_worths({name: one.pairs for name, one in cells.items()}, laws, rules.confidence),
        prices=prices_over(cells, rules),
    )


def check_tested(choice: "pd.DataFrame", tests: "pd.DataFrame") -> None:
    """Refuse gains that were chosen and not tested."""
    seen = set(zip(tests["law"], tests["cell"], tests["level"], strict=True))
    for law, cell, level in zip(choice["law"], choice["cell"], choice["level"], strict=True):
        if (law, cell, level) not in seen:
            where = f"law {law}, cell {cell}, level {level_name(level)}"
            raise HydroservoError(f"the study's table: {where}: no test runs")


def checked_laws(manifest: Mapping[str, Any], used: set[str]) -> dict[str, dict[str, str]]:
    """What the manifest says of the laws that the table has."""
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


def prices_over(cells: Mapping[str, CellVerdict], rules: Rules) -> dict[str, ErrorRatio]:
    found: dict[str, dict[str, tuple[float, float, float]]] = {}
    for cell, verdict in cells.items():
        for one in verdict.prices:
            ratio = (one.ratio, one.low, one.high)
            found.setdefault(f"{one.without} over {one.with_it}", {})[cell] = ratio
    return {name: ratio_over_cells(ratios, rules.confidence) for name, ratios in sorted(found.items())}


def as_json_value(value: Any) -> Any:
    """Records as objects, and what is no number or infinite as null."""
    if hasattr(value, "_asdict"):
        return as_json_value(value._asdict())
    if isinstance(value, Mapping):
        return {str(name): as_json_value(one) for name, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_json_value(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
