"""Which effort is taken: chosen on the validation conditions, which are neither searched nor judged on."""

from typing import TYPE_CHECKING

import numpy as np

from hydroservo.errors import HydroservoError
from hydroservo.studies.columns import TRIED

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["chosen", "of_choice"]


def chosen(table: "pd.DataFrame") -> "pd.DataFrame":
    """The effort of each search at each budget: fewest lost on validation, then the least mean error.

    The mean is geometric, over the runs that are not lost; where that is equal too the least effort is
    taken. A study of one effort needs no validation.

    Args:
        table: what :func:`~hydroservo.studies.columns.judged_columns` gives.

    Returns:
        The columns law, cell, optimiser, search_seed, budget and effort, a row each.

    Raises:
        HydroservoError: a search has several efforts, and no validation runs for one of them.
    """
    tried = table[[*TRIED, "effort"]].drop_duplicates()
    validation = table[table["split"] == "validation"]
    if tried["effort"].nunique() == 1:
        return tried.sort_values(TRIED, ignore_index=True)
    seen = validation[[*TRIED, "effort"]].drop_duplicates()
    if len(seen) < len(tried):
        without = tried.merge(seen, how="left", indicator=True).query("_merge == 'left_only'").iloc[0]
        where = f"law {without['law']}, cell {without['cell']}, effort {without['effort']:g}"
        raise HydroservoError(
            f"the study's table: {where}: no validation runs, by which the effort is chosen"
        )
    logs = validation.assign(log=np.log(validation["error"]))
    found = logs.groupby([*TRIED, "effort"], observed=True, as_index=False).agg(
        {"lost": "sum", "log": "mean"}
    )
    ordered = found.sort_values([*TRIED, "lost", "log", "effort"])
    return ordered.drop_duplicates(TRIED)[[*TRIED, "effort"]].reset_index(drop=True)


def of_choice(table: "pd.DataFrame", choice: "pd.DataFrame", split: str) -> "pd.DataFrame":
    """The runs of one split with the efforts that were chosen."""
    return table[table["split"] == split].merge(choice, on=[*TRIED, "effort"])
