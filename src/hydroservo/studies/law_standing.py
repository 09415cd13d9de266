"""How one law stands in one cell at one level: error, lost runs, activity, and distance from the limit."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.studies.trials import (
    MeanEstimate,
    Rules,
    Trials,
    exponentials,
    mean_estimate,
    paired_difference,
)

if TYPE_CHECKING:
    import pandas as pd

Flags = NDArray[np.bool_]

Numbers = NDArray[np.float64]
OF_LIMITS = ["cell", "condition", "clairvoyant", "causal", "converged"]  # columns of their table
BELOW = 1e-4  # of a limit: by so much a search may stop short of the optimum


class LostShare(NamedTuple):
    """A share with its interval.

    Attributes:
        lost: how many.
        value: their share.
        low, high: the ends of its interval.
    """

    lost: int
    value: float
    low: float
    high: float


def lost_share(lost: Flags, confidence: float = 0.95) -> LostShare:
    """The share of lost runs with Wilson's interval.

    Source: Wilson 1927, doi:10.2307/2276774.
    """
    from scipy.special import ndtri

    count, n, z = int(lost.sum()), lost.size, float(ndtri(0.5 + confidence / 2.0))
    middle, half = count + z**2 / 2.0, z * math.sqrt(count * (n - count) / n + z**2 / 4.0)
    low, high = (middle - half) / (n + z**2), (middle + half) / (n + z**2)
    return LostShare(count, count / n, low if count else 0.0, high if count < n else 1.0)


def fewer_lost(a: Flags, b: Flags, confidence: float = 0.95) -> MeanEstimate:
    """How much greater a's share of lost runs is than b's.

    Its chance is the larger of two: that of Student's t, and that of the exact sign test over the conditions
    in which one law lost its run and the other did not, which a handful of lost runs does not impress.
    """
    from scipy.special import bdtr

    found = paired_difference(a.astype(np.float64), b.astype(np.float64), confidence)
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    chance = 2.0 * float(bdtr(min(only_a, only_b), only_a + only_b, 0.5))
    return found._replace(chance=max(found.chance, min(chance, 1.0)))


class LawStanding(NamedTuple):
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
    lost: LostShare
    tail: float
    worst: float
    activity: float
    hunting: float
    survived: float
    conditions: int


def law_standing(trials: Trials, survived: float, rules: Rules) -> LawStanding:
    """How a law stands.

    Source: Rockafellar and Uryasev 2000, Optimization of conditional value-at-risk,
    doi:10.21314/JOR.2000.038, for the mean of the worst.
    """
    ordered = np.sort(np.where(trials.lost, np.inf, trials.error))
    count = ordered.size
    known = trials.swing[~np.isnan(trials.swing)]
    error, low, high = exponentials(mean_estimate(trials.logs(), rules.confidence))
    return LawStanding(
        error=error,
        error_low=low,
        error_high=high,
        lost=lost_share(trials.lost, rules.confidence),
        tail=float(ordered[math.ceil(0.9 * count) - 1]),
        worst=float(ordered[count - math.ceil(rules.worst * count) :].mean()),
        activity=known_geometric_mean(np.where(trials.lost, np.nan, trials.activity)),
        hunting=float((known > 0.0).mean()) if known.size else math.nan,
        survived=survived,
        conditions=count,
    )


def known_geometric_mean(values: Numbers) -> float:
    """Of those that are not nan; nan where all are, and 0 if any of them is 0."""
    known = values[~np.isnan(values)]
    with np.errstate(divide="ignore"):
        return float(np.exp(np.log(known).mean())) if known.size else math.nan


class LimitMultiple(NamedTuple):
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
    """The least errors that any command could leave in a cell, and the laws beside them."""

    # the numbers of the test conditions that have a limit; none where none was asked for
    conditions: list[int]
    clairvoyant: float  # the least error of a command which knows the future, geometric mean over them [SI]
    causal: float  # that of one to which jumps are known once they are there
    open: int  # how many more were asked of whose search did not end, or ended at 0; they do not count
    # runs of laws that leave less than the clairvoyant limit: there its search ended in an optimum that is
    # not the best of all
    below: int
    laws: dict[str, LimitMultiple]  # each law beside the limits


def cell_limit(trials: Mapping[str, Trials], limits: "pd.DataFrame", confidence: float = 0.95) -> CellLimit:
    """The laws of a cell beside the limits of its conditions."""
    counts = limits["converged"].astype(bool) & (limits["clairvoyant"] > 0.0)
    known = limits[counts].sort_values("condition")
    clairvoyant, causal = (np.log(known[name].to_numpy(np.float64)) for name in ("clairvoyant", "causal"))
    numbers = known["condition"].to_numpy(np.int64)
    if not numbers.size:
        return CellLimit([], np.nan, np.nan, len(limits), 0, {})
    own = {law: trials_under(one, numbers) for law, one in trials.items()}
    return CellLimit(
        conditions=numbers.tolist(),
        clairvoyant=float(np.exp(clairvoyant.mean())),
        causal=float(np.exp(causal.mean())),
        open=len(limits) - numbers.size,
        below=sum(int((one.logs() < clairvoyant - BELOW).sum()) for one in own.values()),
        laws={law: limit_multiple(one, clairvoyant, causal, confidence) for law, one in own.items()},
    )


def trials_under(trials: Trials, numbers: NDArray[np.int64]) -> Trials:
    """The runs under some of the conditions, which all are there."""
    at = np.searchsorted(trials.conditions, numbers)
    conditions, error, lost, activity, swing = trials
    return Trials(conditions[at], error[at], lost[at], activity[at], swing[at])


def limit_multiple(trials: Trials, clairvoyant: Numbers, causal: Numbers, confidence: float) -> LimitMultiple:
    """A law beside the logarithms of the limits of its conditions."""
    middle, low, high = exponentials(mean_estimate(trials.logs() - clairvoyant, confidence))
    beside = known_geometric_mean(trials.error / np.exp(causal))
    return LimitMultiple(middle, low, high, beside, int(trials.lost.sum()), trials.lost.size)
