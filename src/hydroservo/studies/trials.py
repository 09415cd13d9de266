"""The runs of laws that are compared, and what a comparison goes by."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError, ParameterError

if TYPE_CHECKING:
    import pandas as pd

GAINS = ["law", "cell", "search_seed", "point"]  # name the gains of one point of a front
NAMES = ["law", "cell", "split"]
JUDGED = [*GAINS, "moved", "split", "condition", "scale", "error", "activity", "swing", "lost"]
Numbers = NDArray[np.float64]
LEAST = 1e-12  # a chance is never 0


class Rules(NamedTuple):
    """The numbers of a fair comparison, the same for all laws and cells.

    Attributes:
        confidence: of intervals, and 1 less the level of Holm's correction.
        margin: a ratio of errors nearer to 1 than this one counts as a tie, however sure it is.
        most_lost: a law that loses a greater share of its test runs is out of the running in that cell.
        near_best: a law whose error is below so many times the best one's is near it.
        worst: the share of conditions over which the mean of the worst is taken.
        resamples: of the bootstrap, for shares of factors.
        seed: of the bootstrap.
    """

    confidence: float = 0.95
    margin: float = 1.05
    most_lost: float = 0.1
    near_best: float = 1.1
    worst: float = 0.1
    resamples: int = 10_000
    seed: int = 0


def checked_rules(rules: Rules) -> Rules:
    """Rules that can be gone by."""
    for name in ("confidence", "worst"):
        if not 0.0 < getattr(rules, name) < 1.0:
            raise ParameterError(f"rules.{name}", getattr(rules, name), "must lie between 0 and 1")
    for name in ("margin", "near_best"):
        if not getattr(rules, name) >= 1.0:
            raise ParameterError(f"rules.{name}", getattr(rules, name), "must be 1 or more")
    if not 0.0 <= rules.most_lost < 1.0:
        raise ParameterError("rules.most_lost", rules.most_lost, "must be 0 or more, and below 1")
    if rules.resamples < 1:
        raise ParameterError("rules.resamples", rules.resamples, "must be 1 or more")
    if not 0 <= rules.seed < 2**64:
        raise ParameterError("rules.seed", rules.seed, "must lie in 0..2^64-1")
    return rules


def judged_columns(table: "pd.DataFrame") -> "pd.DataFrame":
    """The columns of a study's table that are judged; an infinite error is a lost run, and nan."""
    missing = [name for name in JUDGED if name not in table.columns]
    if missing:
        raise HydroservoError(f"the study's table: no column {', '.join(missing)}")
    if table.empty:
        raise HydroservoError("the study's table: no rows; no unit of the study is done")
    found = table[JUDGED].copy()
    for name in NAMES:
        found[name] = found[name].astype(str).astype("category")  # in the order of the alphabet
    bad = (found["error"].isna() & ~found["lost"].astype(bool)) | (found["error"] <= 0.0)
    if bad.any():
        one = found[bad].iloc[0]
        where = f"law {one['law']}, cell {one['cell']}, {one['split']} condition {one['condition']}"
        raise HydroservoError(f"the study's table: {where}: error = {one['error']:g}: must be positive")
    found["lost"] = found["lost"].astype(bool) | (found["error"] == float("inf"))
    found["error"] = found["error"].where(~found["lost"])
    return found


class Trials(NamedTuple):
    """What a law came to in a cell: arrays of shape (conditions,)."""

    conditions: NDArray[np.int64]  # their numbers, the same for all laws of the cell
    error: Numbers  # the metric in its SI unit; nan where the run was lost
    lost: NDArray[np.bool_]  # whether it was
    activity: Numbers  # of the command [%/s]
    swing: Numbers  # amplitude of the command in a sustained oscillation [V]; nan where it is not known

    def logs(self) -> Numbers:
        """Logarithms of the errors; nan where the run was lost."""
        return np.log(self.error)


def trials_of(runs: "pd.DataFrame") -> Trials:
    """The runs of one law in one cell at one level, in whatever order they come."""
    ordered = runs.sort_values("condition")
    conditions = ordered["condition"].to_numpy(np.int64)
    if np.unique(conditions).size < conditions.size:
        where = f"law {ordered['law'].iloc[0]}, cell {ordered['cell'].iloc[0]}"
        raise HydroservoError(f"the study's table: {where}: has a condition twice")
    numbers = (ordered[name].to_numpy(np.float64) for name in ("error", "activity", "swing"))
    error, activity, swing = numbers
    return Trials(conditions, error, ordered["lost"].to_numpy(np.bool_), activity, swing)


def trials_of_cell(runs: "pd.DataFrame") -> dict[str, Trials]:
    """The runs of all laws of one cell at one level, by law in the order of their names."""
    found = {str(law): trials_of(one) for law, one in runs.groupby("law", observed=True)}
    found = dict(sorted(found.items()))
    first, *others = found.items()
    for law, one in others:
        if not np.array_equal(one.conditions, first[1].conditions):
            cell = runs["cell"].iloc[0]
            problem = f"{first[0]} and {law} met different conditions, and cannot be paired"
            raise HydroservoError(f"the study's table: cell {cell}: {problem}")
    return found


class MeanEstimate(NamedTuple):
    """A mean with its interval; infinitely wide where nothing can be said of it.

    Attributes:
        value: its estimate; nan where there is none.
        low, high: the ends of its interval.
        chance: of a mean at least as far from 0 where it is 0; two-sided.
    """

    value: float
    low: float
    high: float
    chance: float


UNKNOWN = MeanEstimate(np.nan, -np.inf, np.inf, 1.0)


def paired_difference(a: Numbers, b: Numbers, confidence: float = 0.95) -> MeanEstimate:
    """The mean difference of two laws over conditions, by Student's t of their pairs.

    Args:
        a, b: of the same conditions; nan where a run does not count. A condition counts where both do.
        confidence: of the interval.

    Fails: it holds for other conditions, not for other searches: a law whose search stopped too early looks
    worse than it is. With one condition nothing tells the law from luck, and the interval is infinite; it is
    too narrow where few conditions of a long-tailed kind hold the difference.
    """
    return mean_estimate(a - b, confidence)


def mean_estimate(values: Numbers, confidence: float = 0.95) -> MeanEstimate:
    """The mean of some draws, by Student's t; those that are nan do not count."""
    from scipy.special import stdtr, stdtrit

    known = values[~np.isnan(values)]
    if not known.size:
        return UNKNOWN
    middle = float(known.mean())
    if known.size < 2:
        return MeanEstimate(middle, -np.inf, np.inf, 1.0)
    error = float(known.std(ddof=1)) / known.size**0.5
    if error == 0.0:
        return MeanEstimate(middle, middle, middle, 1.0 if middle == 0.0 else LEAST)
    half = float(stdtrit(known.size - 1, 0.5 + confidence / 2.0)) * error
    chance = 2.0 * float(stdtr(known.size - 1, -abs(middle) / error))
    return MeanEstimate(middle, middle - half, middle + half, max(chance, LEAST))


def exponentials(logs: MeanEstimate) -> tuple[float, float, float]:
    """A mean of logarithms and the ends of its interval as what they are logarithms of."""
    with np.errstate(over="ignore"):
        value, low, high = np.exp(logs[:3])
    return float(value), float(low), float(high)
