"""The gains that stand for a law in a cell: those of its search in the middle."""

import json
from typing import TYPE_CHECKING

import numpy as np

from hydroservo.studies.choice import chosen, of_choice
from hydroservo.studies.columns import SEARCH, TRIED, judged_columns
from hydroservo.studies.trials import common_budget

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["middle_gains"]

PLACE = ["cell", "law"]
GAINS = [*TRIED, "effort"]


def middle_gains(table: "pd.DataFrame") -> dict[tuple[str, str], dict[str, float]]:
    """The gains of each law's search in the middle, by cell and law: path -> number in SI units.

    It is the search whose error on test is the median one, of an even number the better one in the middle,
    after as many candidates as the cell is judged at; one that lost all of its runs is behind all others.

    Args:
        table: the study's, with the column ``parameters``.
    """
    runs = judged_columns(table)
    tests = of_choice(runs, chosen(runs), "test")
    at = {str(cell): common_budget(own) for cell, own in tests.groupby("cell", observed=True)}
    tests = tests[tests["budget"] == tests["cell"].astype(str).map(at)]
    logs = tests.assign(log=np.log(tests["error"]))
    searches = logs.groupby([*SEARCH, "budget", "effort"], observed=True, as_index=False).agg({"log": "mean"})
    ordered = searches.sort_values([*PLACE, "log", "optimiser", "search_seed"], na_position="last")
    places = ordered.groupby(PLACE, observed=True)
    some = places["log"].transform("count")
    whole = places["log"].transform("size")
    middle = ordered[places.cumcount() == (some.where(some > 0, whole) - 1) // 2]
    found = middle.merge(table[[*GAINS, "parameters"]].drop_duplicates(GAINS), on=GAINS)
    rows = zip(found["cell"], found["law"], found["parameters"], strict=True)
    return {(str(cell), str(law)): json.loads(gains) for cell, law, gains in rows}
