"""What a part of a law is worth: the law without it against the whole."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from hydroservo.studies.paired import exponentials, mean
from hydroservo.studies.pairs import Pair, compared, ratio_between


class Ratio(NamedTuple):
    """A ratio of errors with its interval.

    Attributes:
        value: its estimate; nan where there is none.
        low, high: the ends of its interval.
    """

    value: float
    low: float
    high: float


class Worth(NamedTuple):
    """What a part of a law is worth: the error without it over that of the whole law.

    Attributes:
        part: what is left out.
        whole: the name of the law that has it.
        cells: the ratio in each cell in which both are.
        over_cells: its geometric mean.
        wins, ties, losses: in how many cells the whole law wins against the one without the part, ties with
            it, and loses to it.
    """

    part: str
    whole: str
    cells: dict[str, Ratio]
    over_cells: Ratio
    wins: int
    ties: int
    losses: int


def worths(
    pairs: Mapping[str, list[Pair]], laws: Mapping[str, Mapping[str, Any]], confidence: float
) -> dict[str, Worth]:
    """What parts are worth, by the name of the law that lacks one.

    Args:
        pairs: of each cell's laws, by cell.
        laws: those of the study's manifest that the study's table has.
        confidence: of the intervals.
    """
    found = {}
    for law, whole in {name: own["of"] for name, own in laws.items() if own["of"] in laws}.items():
        own = {
            cell: one for cell, one in pairs.items() if {law, whole} <= {name for p in one for name in p[:2]}
        }
        ratios = {cell: Ratio(*ratio_between(one, law, whole)) for cell, one in own.items()}
        winners = [compared(one, law, whole).winner for one in own.values()]
        over = over_cells(ratios, confidence)
        counts = (winners.count(whole), winners.count(""), winners.count(law))
        found[law] = Worth(laws[law]["without"], whole, ratios, over, *counts)
    return found


def over_cells(ratios: Mapping[str, tuple[float, float, float]], confidence: float) -> Ratio:
    """The geometric mean of a ratio over cells, with an interval for cells that were not asked.

    Args:
        ratios: of each cell, with its interval; nan where there is none.
        confidence: of the interval: Student's t over cells; of one cell, the interval that it has.
    """
    known = [one for one in ratios.values() if not math.isnan(one[0])]
    if len(known) == 1:
        return Ratio(*known[0])
    return Ratio(*exponentials(mean(np.log([one[0] for one in known]), confidence)))
