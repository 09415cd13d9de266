"""The mean logarithm of each law's errors in a cell, with the bootstrap's draws of it."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.draws import drawn_mean, weights
from hydroservo.studies.rules import Rules
from hydroservo.studies.trials import Trials

FACTORS = ("family", "observer", "wrapper")

Numbers = NDArray[np.float64]


class Means(NamedTuple):
    """The mean logarithm of the errors of the laws in one cell.

    Attributes:
        laws: their names.
        values: shape (1 + resamples, laws): the estimates, and the draws of the bootstrap.
    """

    laws: Sequence[str]
    values: Numbers


def means_of(
    trials: Mapping[str, Mapping[str, Trials]], laws: Mapping[str, Mapping[str, str]], rules: Rules
) -> dict[str, Means]:
    """The mean logarithms of the errors of the laws that lack nothing and do not lose too many runs.

    Args:
        trials: the test runs, by cell and law.
        laws: their factors and what they are ``without``.
        rules: of the comparison.

    Returns:
        Those of each cell that has two such laws or more; of none where no factor has two levels.
    """
    whole = {name for name, own in laws.items() if not own["without"]}
    found: dict[str, Means] = {}
    if all(len({laws[law][factor] for law in whole}) < 2 for factor in FACTORS):
        return found
    for cell, own in trials.items():
        running = [law for law in own if law in whole and own[law].lost.mean() <= rules.most_lost]
        if len(running) > 1:
            drawn = weights(own[running[0]].conditions.size, rules, cell)
            found[cell] = Means(running, np.stack([values_of(own[law], drawn) for law in running], axis=1))
    return found


def values_of(trials: Trials, drawn: Numbers) -> Numbers:
    """The mean logarithm of a law's errors, and after it the draws of it."""
    return np.concatenate(([np.nanmean(trials.logs())], drawn_mean(trials, drawn)))
