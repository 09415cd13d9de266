"""Who wins a cell, and who cannot be told from the winner."""

from collections.abc import Mapping
from typing import NamedTuple

from hydroservo.studies.pairs import Pair, ratio_between, rivals_of
from hydroservo.studies.rules import Rules
from hydroservo.studies.standing import Standing


class Best(NamedTuple):
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


NONE = Best("", [], [], "none", "", float("nan"), 0.0, float("inf"))


def best_of(
    standings: Mapping[str, Standing], pairs: list[Pair], families: Mapping[str, str], rules: Rules
) -> Best:
    """The best law among those that do not lose too many runs.

    Args:
        standings: of the cell's laws by name.
        pairs: of these laws.
        families: of laws by name.
        rules: of the comparison.
    """
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
    return Best(law, ties, tied, "tie" if len(tied) > 1 else "won", following, *margin)
