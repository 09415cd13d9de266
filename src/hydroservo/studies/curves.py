"""Error against budget: whether the search was long enough, and whether it was so for all laws."""

from typing import TYPE_CHECKING, NamedTuple

from hydroservo.studies.standing import quartiles, search_errors
from hydroservo.studies.trials import trials_of

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Stage", "curve"]


class Stage(NamedTuple):
    """What the searches of a law had come to after so many candidates.

    Attributes:
        budget: how many.
        error: geometric mean over the test conditions whose runs were not lost; median over searches.
        low, high: the quartiles over searches.
        lost: the share of lost runs, which the error does not know of.
        searches: how many reached that budget.
    """

    budget: int
    error: float
    low: float
    high: float
    lost: float
    searches: int


def curve(runs: "pd.DataFrame") -> list[Stage]:
    """The stages of one law in one cell, each with the effort that validation would have chosen by then.

    Args:
        runs: the law's test runs in the cell with the chosen efforts, at all budgets.
    """
    found = []
    for budget, own in runs.groupby("budget"):
        trials = trials_of(own)
        low, middle, high = quartiles(search_errors(trials))
        found.append(Stage(int(str(budget)), middle, low, high, float(trials.lost.mean()), len(trials.lost)))
    return found
