"""All that a study says of one cell at one level of activity."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.studies.ablation import Ratio
from hydroservo.studies.best import Best, best_of
from hydroservo.studies.fronts import ratio_of
from hydroservo.studies.multiples import CellLimit, limit_of
from hydroservo.studies.pairs import Pair, pairs_of
from hydroservo.studies.properties import Properties
from hydroservo.studies.regret import regrets
from hydroservo.studies.rules import Rules
from hydroservo.studies.sensing import Price, prices, ranks
from hydroservo.studies.standing import Standing, geometric_mean, standing_of
from hydroservo.studies.stress import survived
from hydroservo.studies.trials import Trials, trials_of_cell

if TYPE_CHECKING:
    import pandas as pd

Laws = Mapping[str, Mapping[str, Any]]


class CellVerdict(NamedTuple):
    """All that a study says of one cell at one level; of the laws that can be so calm.

    Attributes:
        best: who wins.
        standings: each law by itself.
        pairs: each law against each other.
        to_own: the error of each law over that of the reference at its own activity, on the same conditions.
        kinds: the same on the conditions of each kind, by its place among the study's kinds.
        regret: of each law.
        ranks: of each law among those with the same sensors.
        prices: of sensors.
        limit: the least errors that any command could leave, and each law beside them.
        properties: the margins of each law and its price on the target; empty where nobody computed them.
    """

    best: Best
    standings: dict[str, Standing]
    pairs: list[Pair]
    to_own: dict[str, Ratio]
    kinds: dict[str, list[float]]
    regret: dict[str, float]
    ranks: dict[str, int]
    prices: list[Price]
    limit: CellLimit
    properties: Mapping[str, Properties]


def cell_verdict(
    tests: "pd.DataFrame",
    stress: "pd.DataFrame",
    base: Trials,
    laws: Laws,
    kinds: int,
    rules: Rules,
    limits: "pd.DataFrame",
    properties: Mapping[str, Properties],
) -> tuple[CellVerdict, dict[str, Trials]]:
    """What a study says of one cell at one level, and the runs that it says it of.

    Args:
        tests, stress: the runs there with the gains that validation chose.
        base: those of the reference at its own activity.
        laws: those of the study's manifest.
        kinds: how many kinds of conditions take turns.
        rules: of the comparison.
        limits: of the cell's conditions.
        properties: of the laws, by name.

    Raises:
        HydroservoError: the laws' runs cannot be paired.
    """
    trials = trials_of_cell(tests)
    standings = {
        law: standing_of(one, survived(stress[stress["law"] == law]), rules) for law, one in trials.items()
    }
    pairs = pairs_of(trials, rules)
    classes = {law: str(laws[law]["class"]) for law in trials}
    found = CellVerdict(
        best=best_of(standings, pairs, {law: str(laws[law]["family"]) for law in trials}, rules),
        standings=standings,
        pairs=pairs,
        to_own={law: ratio_of(one, base, rules) for law, one in trials.items()},
        kinds={law: kind_ratios(one, base, kinds) for law, one in trials.items()},
        regret=regrets(standings, pairs, rules),
        ranks=ranks(pairs, classes),
        prices=prices(standings, pairs, classes, rules),
        limit=limit_of(trials, limits, rules.confidence),
        properties=properties,
    )
    return found, trials


def kind_ratios(trials: Trials, base: Trials, kinds: int) -> list[float]:
    """The error over another under each kind of conditions, where neither run was lost; nan for none."""
    ratios, kind = trials.error / base.error, trials.conditions % kinds
    return [geometric_mean(ratios[kind == k]) for k in range(kinds)]
