"""All that a study says of one cell."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.errors import HydroservoError
from hydroservo.studies.best import Best, best_of
from hydroservo.studies.choice import of_choice
from hydroservo.studies.curves import Stage, curve
from hydroservo.studies.front import Point, with_front
from hydroservo.studies.multiples import CellLimit, limit_of
from hydroservo.studies.pairs import Pair, pairs_of
from hydroservo.studies.properties import Properties
from hydroservo.studies.regret import regrets
from hydroservo.studies.rules import Rules
from hydroservo.studies.sensing import Price, prices, ranks
from hydroservo.studies.standing import Standing, standing_of
from hydroservo.studies.stress import survived
from hydroservo.studies.trials import Trials, common_budget, trials_of, trials_of_cell

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["CellVerdict", "cell_verdict"]

Laws = Mapping[str, Mapping[str, Any]]


class CellVerdict(NamedTuple):
    """All that a study says of one cell.

    Attributes:
        budget: the largest that all searches reached, at which all is judged but the curves.
        best: who wins.
        standings: each law by itself.
        pairs: each law against each other.
        regret: of each law.
        ranks: of each law among those with the same sensors.
        prices: of sensors.
        front: each law with each weight of effort, and which of these are on the front.
        curves: error against budget, of each law.
        limit: the least errors that any command could leave, and each law beside them.
        properties: the margins of each law and its price on the target; empty where nobody computed them.
    """

    budget: int
    best: Best
    standings: dict[str, Standing]
    pairs: list[Pair]
    regret: dict[str, float]
    ranks: dict[str, int]
    prices: list[Price]
    front: list[Point]
    curves: dict[str, list[Stage]]
    limit: CellLimit
    properties: Mapping[str, Properties]


def cell_verdict(
    runs: "pd.DataFrame",
    choice: "pd.DataFrame",
    laws: Laws,
    rules: Rules,
    limits: "pd.DataFrame",
    properties: Mapping[str, Properties],
) -> tuple[CellVerdict, dict[str, Trials]]:
    """What a study says of one cell, and the runs that it says it of.

    Args:
        runs: the cell's rows of the table.
        choice: the efforts that validation chose.
        laws: those of the study's manifest.
        rules: of the comparison.
        limits: of the study's conditions.
        properties: of the laws, by name.

    Raises:
        HydroservoError: a law of the cell has no test runs, or the laws' runs cannot be paired.
    """
    tests, stress = of_choice(runs, choice, "test"), of_choice(runs, choice, "stress")
    without = sorted(set(runs["law"].unique()) - set(tests["law"].unique()))
    if without:
        where = f"law {without[0]}, cell {runs['cell'].iloc[0]}"
        raise HydroservoError(f"the study's table: {where}: no test runs")
    budget = common_budget(tests)
    trials = trials_of_cell(tests[tests["budget"] == budget])
    strained = stress[stress["budget"] == budget]
    standings = {
        law: standing_of(one, survived(strained[strained["law"] == law]), rules)
        for law, one in trials.items()
    }
    pairs = pairs_of(trials, rules)
    classes = {law: str(laws[law]["class"]) for law in trials}
    found = CellVerdict(
        budget=budget,
        best=best_of(standings, pairs, {law: str(laws[law]["family"]) for law in trials}, rules),
        standings=standings,
        pairs=pairs,
        regret=regrets(standings, pairs, rules),
        ranks=ranks(pairs, classes),
        prices=prices(standings, pairs, classes, rules),
        front=with_front(points(runs[runs["budget"] == budget], rules), rules.most_lost),
        curves={law: curve(tests[tests["law"] == law]) for law in trials},
        limit=limit_of(trials, limits[limits["cell"] == runs["cell"].iloc[0]]),
        properties=properties,
    )
    return found, trials


def points(runs: "pd.DataFrame", rules: Rules) -> list[Point]:
    """Each law with each weight of effort, at one budget."""
    found = []
    for (law, effort), own in runs.groupby(["law", "effort"], observed=True):
        tests = own[own["split"] == "test"]
        if len(tests):
            one = standing_of(trials_of(tests), survived(own[own["split"] == "stress"]), rules)
            name, weight = str(law), float(str(effort))
            found.append(
                Point(name, weight, one.error, one.activity, one.survived, one.lost.value, front=False)
            )
    return found
