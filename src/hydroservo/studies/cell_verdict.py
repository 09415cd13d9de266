"""All that a study says of one cell at one level of activity."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydroservo.studies.fronts import ratio_of
from hydroservo.studies.law_pairs import ErrorRatio, LawPair, pairs_of, ratio_between, rivals_of
from hydroservo.studies.law_standing import (
    CellLimit,
    LawStanding,
    cell_limit,
    known_geometric_mean,
    law_standing,
)
from hydroservo.studies.properties import Properties
from hydroservo.studies.trials import Rules, Trials, trials_of_cell

if TYPE_CHECKING:
    import pandas as pd

CLASSES = ("V", "VP", "VPX")  # velocity or position; with the load pressure; with the spool's place too
ManifestLaws = Mapping[str, Mapping[str, Any]]


def survived_scale(runs: "pd.DataFrame") -> float:
    """The largest scale of uncertainty at and below which no run was lost.

    Returns:
        A multiple of the nominal uncertainty; 0 where runs were lost at the smallest, nan where there are
        none.

    Fails: the largest scale that was tried is the most it can say.
    """
    if runs.empty:
        return np.nan
    lost = runs.groupby("scale")["lost"].any().sort_index()
    steps = int((~lost.to_numpy(np.bool_)).cumprod().sum())
    return float(lost.index[steps - 1]) if steps else 0.0


class BestLaw(NamedTuple):
    """The best law of a cell.

    Attributes:
        law: the one that fewest others beat, and of these the one with the least error; empty where there is
            none.
        ties: it and the laws that tie with it.
        families: theirs.
        state: ``"won"`` by one family, ``"tie"`` of several, or ``"none"``: each law loses too many runs.
        next_family: the law of another family with the least error; empty where there is none.
        margin, margin_low, margin_high: the error of that law over the best one's with its interval.
    """

    law: str
    ties: list[str]
    families: list[str]
    state: str
    next_family: str
    margin: float
    margin_low: float
    margin_high: float


NONE = BestLaw("", [], [], "none", "", float("nan"), 0.0, float("inf"))


def best_law(
    standings: Mapping[str, LawStanding], pairs: list[LawPair], families: Mapping[str, str], rules: Rules
) -> BestLaw:
    """The best law among those that do not lose too many runs."""
    running = [law for law in sorted(standings) if standings[law].lost.value <= rules.most_lost]
    if not running:
        return NONE
    among = [pair for pair in pairs if pair.a in running and pair.b in running]
    beaten = {law: rivals_of(among, law)[0] for law in running}
    law = min(running, key=lambda one: (len(beaten[one]), standings[one].error))
    ties = sorted([law, *rivals_of(among, law)[1]])
    tied = sorted({families[one] for one in ties})
    others = [one for one in running if families[one] != families[law]]
    following = min(others, key=lambda one: standings[one].error, default="")
    margin = ratio_between(pairs, following, law) if following else NONE[-3:]
    return BestLaw(law, ties, tied, "tie" if len(tied) > 1 else "won", following, *margin)


class Area(NamedTuple):
    """Over how much of the map a law is near the best.

    Attributes:
        near_best: the share of the cells with a best law in which the law's regret is below the rules' limit.
        lost: the share in which it loses too many runs.
        cells: how many cells have a best law.
        largest: the largest regret where it does not.
    """

    near_best: float
    lost: float
    cells: int
    largest: float


def regrets(standings: Mapping[str, LawStanding], pairs: list[LawPair], rules: Rules) -> dict[str, float]:
    """The regret of each law of a cell: its error over the least one of the cell, over the same conditions.

    Infinite of a law that loses too many runs, nan of all where each does. A law with less error than others
    and more lost runs, though not too many, is the measure of theirs.

    Fails: the least of many errors is least by luck too, so all regrets are a little too large where many
    laws tie.
    """
    running = [law for law in sorted(standings) if standings[law].lost.value <= rules.most_lost]
    if not running:
        return dict.fromkeys(standings, math.nan)
    least = min(running, key=lambda law: standings[law].error)
    return {law: ratio_between(pairs, law, least)[0] if law in running else math.inf for law in standings}


def law_areas(regret: Mapping[str, Mapping[str, float]], rules: Rules) -> dict[str, Area]:
    """How much of the map each law is near the best in."""
    laws = sorted({law for cell in regret.values() for law in cell})
    cells = [cell for cell in regret.values() if not all(map(math.isnan, cell.values()))]
    count = len(cells)
    found = {}
    for law in laws:
        own = [cell[law] for cell in cells if law in cell]
        near, lost = sum(one < rules.near_best for one in own), sum(map(math.isinf, own))
        shares = (near / count, lost / count) if count else (math.nan, math.nan)
        found[law] = Area(*shares, count, max((one for one in own if one < math.inf), default=math.nan))
    return found


class Price(NamedTuple):
    """What the best law without a sensor gives up to the best with it.

    Attributes:
        without, with_it: classes of sensors.
        law_without, law_with_it: the best laws of these classes.
        ratio, low, high: the error of the first over that of the second, with its interval.
    """

    without: str
    with_it: str
    law_without: str
    law_with_it: str
    ratio: float
    low: float
    high: float


def sensor_ranks(pairs: list[LawPair], classes: Mapping[str, str]) -> dict[str, int]:
    """The rank of each law among those with the same sensors: 1, and 1 more for each that beats it."""
    return {
        law: 1 + sum(classes[one] == own for one in rivals_of(pairs, law)[0]) for law, own in classes.items()
    }


def sensor_prices(
    standings: Mapping[str, LawStanding], pairs: list[LawPair], classes: Mapping[str, str], rules: Rules
) -> list[Price]:
    """The prices between classes of sensors that follow one another, where both have a law that stays.

    Fails: the best of many laws is best by luck too; a class with more laws looks a little better.
    """
    best = {}
    for one in CLASSES:
        own = {law: standing for law, standing in standings.items() if classes[law] == one}
        law = best_law(own, pairs, dict.fromkeys(own, one), rules).law
        if law:
            best[one] = law
    found = []
    for without, with_it in pairwise(best):
        ratio = ratio_between(pairs, best[without], best[with_it])
        found.append(Price(without, with_it, best[without], best[with_it], *ratio))
    return found


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

    best: BestLaw
    standings: dict[str, LawStanding]
    pairs: list[LawPair]
    to_own: dict[str, ErrorRatio]
    kinds: dict[str, list[float]]
    regret: dict[str, float]
    ranks: dict[str, int]
    prices: list[Price]
    limit: CellLimit
    properties: Mapping[str, Properties]


class Comparison(NamedTuple):
    """What the laws of a study are compared by.

    Attributes:
        laws: those of the study's manifest.
        kinds: how many kinds of conditions take turns.
        rules: of the comparison.
        limits: of the conditions of all cells.
    """

    laws: ManifestLaws
    kinds: int
    rules: Rules
    limits: "pd.DataFrame"


def cell_verdict(
    tests: "pd.DataFrame",
    stress: "pd.DataFrame",
    base: Trials,
    by: Comparison,
    properties: Mapping[str, Properties],
) -> tuple[CellVerdict, dict[str, Trials]]:
    """What a study says of one cell at one level, and the runs that it says it of.

    ``tests`` and ``stress`` are the runs there with the gains that validation chose, ``base`` those of the
    reference at its own activity.
    """
    laws, kinds, rules, limits = by
    trials = trials_of_cell(tests)
    standings = {
        law: law_standing(one, survived_scale(stress[stress["law"] == law]), rules)
        for law, one in trials.items()
    }
    pairs = pairs_of(trials, rules)
    classes = {law: str(laws[law]["class"]) for law in trials}
    found = CellVerdict(
        best=best_law(standings, pairs, {law: str(laws[law]["family"]) for law in trials}, rules),
        standings=standings,
        pairs=pairs,
        to_own={law: ratio_of(one, base, rules) for law, one in trials.items()},
        kinds={law: kind_ratios(one, base, kinds) for law, one in trials.items()},
        regret=regrets(standings, pairs, rules),
        ranks=sensor_ranks(pairs, classes),
        prices=sensor_prices(standings, pairs, classes, rules),
        limit=cell_limit(trials, limits, rules.confidence),
        properties=properties,
    )
    return found, trials


def kind_ratios(trials: Trials, base: Trials, kinds: int) -> list[float]:
    """The error over another under each kind of conditions, where neither run was lost; nan for none."""
    ratios, kind = trials.error / base.error, trials.conditions % kinds
    return [known_geometric_mean(ratios[kind == k]) for k in range(kinds)]
