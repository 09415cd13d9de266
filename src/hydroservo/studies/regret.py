"""What a law costs where another is better: its error over the best law's."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from hydroservo.studies.pairs import Pair, ratio_between
from hydroservo.studies.rules import Rules
from hydroservo.studies.standing import Standing


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


def regrets(standings: Mapping[str, Standing], pairs: list[Pair], rules: Rules) -> dict[str, float]:
    """The regret of each law of a cell: its error over the least one of the cell, over the same conditions.

    Infinite of a law that loses too many runs, nan of all where each does. A law with less error than others
    and more lost runs, though not too many, is the measure of theirs.

    Args:
        standings: of the cell's laws by name.
        pairs: of these laws.
        rules: of the comparison.

    Fails: the least of many errors is least by luck too, so all regrets are a little too large where many
    laws tie.
    """
    running = [law for law in sorted(standings) if standings[law].lost.value <= rules.most_lost]
    if not running:
        return dict.fromkeys(standings, math.nan)
    least = min(running, key=lambda law: standings[law].error)
    return {law: ratio_between(pairs, law, least)[0] if law in running else math.inf for law in standings}


def areas(regret: Mapping[str, Mapping[str, float]], rules: Rules) -> dict[str, Area]:
    """How much of the map each law is near the best in.

    Args:
        regret: by cell and law.
        rules: of the comparison.
    """
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
