"""How far the laws of a cell are from the least error that any command could leave."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.paired import exponentials, mean
from hydroservo.studies.standing import geometric_mean
from hydroservo.studies.trials import Trials

if TYPE_CHECKING:
    import pandas as pd

OF_LIMITS = ["cell", "condition", "clairvoyant", "causal", "converged"]  # columns of their table
BELOW = 1e-4  # of a limit: by so much a search may stop short of the optimum

Numbers = NDArray[np.float64]


class Multiple(NamedTuple):
    """How many times the limits a law leaves, on the conditions that have one.

    Attributes:
        clairvoyant: error over that of the best command which knows the future; geometric mean over the
            conditions of the runs that were not lost.
        low, high: its interval.
        causal: error over that of the best command to which jumps are known once they are there; likewise.
        lost: how many of these runs were lost, which count in none of it.
        runs: how many there are.
    """

    clairvoyant: float
    low: float
    high: float
    causal: float
    lost: int
    runs: int


class CellLimit(NamedTuple):
    """The least errors that any command could leave in a cell, and the laws beside them.

    Attributes:
        conditions: the numbers of the test conditions that have a limit; none where none was asked for.
        clairvoyant: the least error of a command which knows the future, geometric mean over them [SI].
        causal: that of one to which jumps are known once they are there.
        open: how many more were asked of whose search did not end, or ended at 0; they do not count.
        below: runs of laws that leave less than the clairvoyant limit: there its search ended in an optimum
            that is not the best of all.
        laws: each law beside the limits.
    """

    conditions: list[int]
    clairvoyant: float
    causal: float
    open: int
    below: int
    laws: dict[str, Multiple]


def limit_of(trials: Mapping[str, Trials], limits: "pd.DataFrame", confidence: float = 0.95) -> CellLimit:
    """The laws of a cell beside the limits of its conditions.

    Args:
        trials: the test runs of each law.
        limits: a row for each condition of the cell whose limits were sought.
        confidence: of the intervals.
    """
    counts = limits["converged"].astype(bool) & (limits["clairvoyant"] > 0.0)
    known = limits[counts].sort_values("condition")
    clairvoyant, causal = (np.log(known[name].to_numpy(np.float64)) for name in ("clairvoyant", "causal"))
    numbers = known["condition"].to_numpy(np.int64)
    if not numbers.size:
        return CellLimit([], np.nan, np.nan, len(limits), 0, {})
    own = {law: of_conditions(one, numbers) for law, one in trials.items()}
    return CellLimit(
        conditions=numbers.tolist(),
        clairvoyant=float(np.exp(clairvoyant.mean())),
        causal=float(np.exp(causal.mean())),
        open=len(limits) - numbers.size,
        below=sum(int((one.logs() < clairvoyant - BELOW).sum()) for one in own.values()),
        laws={law: multiple(one, clairvoyant, causal, confidence) for law, one in own.items()},
    )


def of_conditions(trials: Trials, numbers: NDArray[np.int64]) -> Trials:
    """The runs under some of the conditions, which all are there."""
    at = np.searchsorted(trials.conditions, numbers)
    conditions, error, lost, activity, swing = trials
    return Trials(conditions[at], error[at], lost[at], activity[at], swing[at])


def multiple(trials: Trials, clairvoyant: Numbers, causal: Numbers, confidence: float) -> Multiple:
    """A law beside the logarithms of the limits of its conditions."""
    middle, low, high = exponentials(mean(trials.logs() - clairvoyant, confidence))
    beside = geometric_mean(trials.error / np.exp(causal))
    return Multiple(middle, low, high, beside, int(trials.lost.sum()), trials.lost.size)
