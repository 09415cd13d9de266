"""Laws that are given the same sensors against each other, and what another sensor is worth."""

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

from hydroservo.studies.best import best_of
from hydroservo.studies.pairs import Pair, ratio_between, rivals_of
from hydroservo.studies.rules import Rules
from hydroservo.studies.standing import Standing

CLASSES = ("V", "VP", "VPX")  # velocity or position; with the load pressure; with the spool's place too


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


def ranks(pairs: list[Pair], classes: Mapping[str, str]) -> dict[str, int]:
    """The rank of each law among those with the same sensors: 1, and 1 more for each that beats it.

    Args:
        pairs: of the cell's laws.
        classes: of these laws by name.
    """
    return {
        law: 1 + sum(classes[one] == own for one in rivals_of(pairs, law)[0]) for law, own in classes.items()
    }


def prices(
    standings: Mapping[str, Standing], pairs: list[Pair], classes: Mapping[str, str], rules: Rules
) -> list[Price]:
    """The prices between classes of sensors that follow one another, where both have a law that stays.

    Args:
        standings: of the cell's laws by name.
        pairs: of these laws.
        classes: of these laws by name.
        rules: of the comparison.

    Fails: the best of many laws is best by luck too; a class with more laws looks a little better.
    """
    best = {}
    for one in CLASSES:
        own = {law: standing for law, standing in standings.items() if classes[law] == one}
        law = best_of(own, pairs, dict.fromkeys(own, one), rules).law
        if law:
            best[one] = law
    found = []
    for without, with_it in pairwise(best):
        ratio = ratio_between(pairs, best[without], best[with_it])
        found.append(Price(without, with_it, best[without], best[with_it], *ratio))
    return found
