"""How one law stands in one cell, by itself: error, tail, lost runs, activity, what it survives."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.losses import Share, lost_share
from hydroservo.studies.rules import Rules
from hydroservo.studies.trials import Trials

__all__ = ["Standing", "search_errors", "standing_of", "tails"]

Numbers = NDArray[np.float64]


class Standing(NamedTuple):
    """One law in one cell at the full budget, on the test conditions.

    Attributes:
        error: geometric mean over the conditions of the runs that were not lost; median over searches.
        error_low, error_high: the quartiles over searches.
        lost: the share of lost runs.
        tail: the 90th percentile of the error over conditions, a lost run being beyond all; median over
            searches.
        worst: the mean of the worst share of conditions; likewise.
        activity: of the command [%/s]; median over all runs that were not lost.
        survived: the largest multiple of the nominal uncertainty at and below which no run was lost, median
            over searches; nan where the study has no stress runs.
        searches, conditions: how many.
    """

    error: float
    error_low: float
    error_high: float
    lost: Share
    tail: float
    worst: float
    activity: float
    survived: float
    searches: int
    conditions: int


def standing_of(trials: Trials, survived: float, rules: Rules) -> Standing:
    """How a law stands.

    Args:
        trials: its test runs.
        survived: what :func:`~hydroservo.studies.stress.survived` says of it.
        rules: of the comparison.
    """
    low, middle, high = quartiles(search_errors(trials))
    tail, worst = tails(trials, rules.worst)
    kept = trials.activity[~trials.lost]
    return Standing(
        error=middle,
        error_low=low,
        error_high=high,
        lost=lost_share(trials.lost, rules.confidence),
        tail=tail,
        worst=worst,
        activity=float(np.median(kept)) if kept.size else np.nan,
        survived=survived,
        searches=len(trials.lost),
        conditions=trials.conditions.size,
    )


def search_errors(trials: Trials) -> Numbers:
    """The geometric mean error of each search, over its runs that were not lost; left out where all were."""
    some = ~trials.lost.all(axis=1)
    found: Numbers = np.exp(np.nanmean(trials.logs()[some], axis=1))
    return found


def quartiles(values: Numbers) -> tuple[float, float, float]:
    """The quartiles and the median between them; nan of nothing."""
    if not values.size:
        return np.nan, np.nan, np.nan
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return float(low), float(middle), float(high)


def tails(trials: Trials, worst: float) -> tuple[float, float]:
    """The 90th percentile of the error over conditions, and the mean of the worst; medians over searches.

    A lost run is infinitely bad in both: the mean of the worst is infinite if any run of the search was lost.

    Args:
        trials: the test runs of a law.
        worst: the share of conditions, rounded up to whole ones.

    Source: Rockafellar and Uryasev 2000, Optimization of conditional value-at-risk,
    doi:10.21314/JOR.2000.038.
    """
    ordered = np.sort(np.where(trials.lost, np.inf, trials.error), axis=1)
    count = ordered.shape[1]
    ninetieth = ordered[:, int(np.ceil(0.9 * count)) - 1]
    means = ordered[:, count - int(np.ceil(worst * count)) :].mean(axis=1)
    return middle_of(ninetieth), middle_of(means)


def middle_of(values: Numbers) -> float:
    """The median, of two middle ones the larger; that of infinite numbers is infinite."""
    return float(np.sort(values)[values.size // 2])
