"""The columns of a study's table that are judged, and whether they can be."""

from typing import TYPE_CHECKING

from hydroservo.errors import HydroservoError

if TYPE_CHECKING:
    import pandas as pd

GAINS = ["law", "cell", "search_seed", "point"]  # name the gains of one point of a front
NAMES = ["law", "cell", "split"]
JUDGED = [*GAINS, "moved", "split", "condition", "scale", "error", "activity", "swing", "lost"]


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
