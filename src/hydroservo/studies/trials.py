"""The runs of one law in one cell at one level, as arrays."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import HydroservoError

if TYPE_CHECKING:
    import pandas as pd

Numbers = NDArray[np.float64]


class Trials(NamedTuple):
    """What a law came to in a cell: arrays of shape (conditions,).

    Attributes:
        conditions: their numbers, the same for all laws of the cell.
        error: the metric in its SI unit; nan where the run was lost.
        lost: whether it was.
        activity: of the command [%/s].
        swing: amplitude of the command in a sustained oscillation [V]; nan where it is not known.
    """

    conditions: NDArray[np.int64]
    error: Numbers
    lost: NDArray[np.bool_]
    activity: Numbers
    swing: Numbers

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
