"""The runs of one law in one cell, as arrays."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import HydroservoError

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Trials", "common_budget", "trials_of", "trials_of_cell"]

Numbers = NDArray[np.float64]


class Trials(NamedTuple):
    """What the searches of one law came to in one cell; rows are searches, columns conditions.

    Attributes:
        conditions: their numbers, the same for all laws of the cell.
        error: the metric in its SI unit; nan where the run was lost.
        lost: whether it was.
        activity: of the command [%/s].
    """

    conditions: NDArray[np.int64]
    error: Numbers
    lost: NDArray[np.bool_]
    activity: Numbers

    def logs(self) -> Numbers:
        """Logarithms of the errors; nan where the run was lost."""
        return np.log(self.error)


def common_budget(runs: "pd.DataFrame") -> int:
    """The largest budget that all searches of a cell reached: all laws are judged after as many candidates.

    Raises:
        HydroservoError: there is none.
    """
    names = ["law", "optimiser", "search_seed"]
    budgets = [set(one) for _, one in runs.groupby(names, observed=True)["budget"]]
    shared = set.intersection(*budgets)
    if not shared:
        cell = runs["cell"].iloc[0]
        raise HydroservoError(f"the study's table: cell {cell}: no budget that all searches reached")
    return int(max(shared))


def trials_of(runs: "pd.DataFrame") -> Trials:
    """The runs of one law in one cell at one budget, in whatever order they come.

    Raises:
        HydroservoError: a condition is there twice, or is missing in one of the searches.
    """
    ordered = runs.sort_values(["optimiser", "search_seed", "condition"])
    conditions = np.unique(ordered["condition"].to_numpy(np.int64))
    shape = (len(ordered) // conditions.size, conditions.size)
    if not whole(ordered, conditions, shape):
        where = f"law {ordered['law'].iloc[0]}, cell {ordered['cell'].iloc[0]}"
        raise HydroservoError(f"the study's table: {where}: each search must have each condition once")
    error = ordered["error"].to_numpy(np.float64).reshape(shape)
    lost = ordered["lost"].to_numpy(np.bool_).reshape(shape)
    return Trials(conditions, error, lost, ordered["activity"].to_numpy(np.float64).reshape(shape))


def whole(ordered: "pd.DataFrame", conditions: NDArray[np.int64], shape: tuple[int, int]) -> bool:
    """Whether ordered rows are those of searches one after another, each with all conditions once."""
    if len(ordered) != shape[0] * shape[1]:
        return False
    seen = ordered["condition"].to_numpy(np.int64).reshape(shape)
    names = [ordered[name].to_numpy().reshape(shape) for name in ("optimiser", "search_seed")]
    searches = set(zip(*(name[:, 0] for name in names), strict=True))
    one_each = all((name == name[:, :1]).all() for name in names)
    return bool((seen == conditions).all()) and one_each and len(searches) == shape[0]


def trials_of_cell(runs: "pd.DataFrame") -> dict[str, Trials]:
    """The runs of all laws of one cell at one budget, by law in the order of their names.

    Raises:
        HydroservoError: as of :func:`trials_of`; or laws met different conditions.
    """
    found = {str(law): trials_of(one) for law, one in runs.groupby("law", observed=True)}
    found = dict(sorted(found.items()))
    first, *others = found.items()
    for law, one in others:
        if not np.array_equal(one.conditions, first[1].conditions):
            cell = runs["cell"].iloc[0]
            problem = f"{first[0]} and {law} met different conditions, and cannot be paired"
            raise HydroservoError(f"the study's table: cell {cell}: {problem}")
    return found
