"""How one law stands in one cell at one level: error, tail, lost runs, activity, what it survives."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.losses import Share, lost_share
from hydroservo.studies.paired import exponentials, mean
from hydroservo.studies.rules import Rules
from hydroservo.studies.trials import Trials

Numbers = NDArray[np.float64]


class Standing(NamedTuple):
    """One law in one cell at one level, on the test conditions.

    Attributes:
        error: geometric mean over the conditions of the runs that were not lost.
        error_low, error_high: its interval.
        lost: the share of lost runs.
        tail: the 90th percentile of the error over conditions, a lost run being beyond all.
        worst: the mean of the worst share of conditions, infinite if one of them was lost.
        activity: of the command, geometric mean over the runs that were not lost [%/s].
        hunting: the share of runs, of those in which it can be told, whose command oscillates for good; nan
            where it can be told in none.
        survived: the largest multiple of the nominal uncertainty at and below which no run was lost; nan
            where the study has no stress runs.
        conditions: how many.
    """

    error: float
    error_low: float
    error_high: float
    lost: Share
    tail: float
    worst: float
    activity: float
    hunting: float
    survived: float
    conditions: int


def standing_of(trials: Trials, survived: float, rules: Rules) -> Standing:
    """How a law stands.

    Args:
        trials: its test runs.
        survived: what :func:`~hydroservo.studies.stress.survived` says of it.
        rules: of the comparison.

    Source: Rockafellar and Uryasev 2000, Optimization of conditional value-at-risk,
    doi:10.21314/JOR.2000.038, for the mean of the worst.
    """
    ordered = np.sort(np.where(trials.lost, np.inf, trials.error))
    count = ordered.size
    known = trials.swing[~np.isnan(trials.swing)]
    error, low, high = exponentials(mean(trials.logs(), rules.confidence))
    return Standing(
        error=error,
        error_low=low,
        error_high=high,
        lost=lost_share(trials.lost, rules.confidence),
        tail=float(ordered[math.ceil(0.9 * count) - 1]),
        worst=float(ordered[count - math.ceil(rules.worst * count) :].mean()),
        activity=geometric_mean(np.where(trials.lost, np.nan, trials.activity)),
        hunting=float((known > 0.0).mean()) if known.size else math.nan,
        survived=survived,
        conditions=count,
    )


def geometric_mean(values: Numbers) -> float:
    """Of those that are not nan; nan where all are, and 0 if any of them is 0."""
    known = values[~np.isnan(values)]
    with np.errstate(divide="ignore"):
        return float(np.exp(np.log(known).mean())) if known.size else math.nan
