"""Which point of a law's front is taken at a level of activity: chosen on the validation conditions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydroservo.errors import HydroservoError
from hydroservo.studies.columns import GAINS
from hydroservo.studies.rules import Rules

if TYPE_CHECKING:
    import pandas as pd

ROUNDING = 1e-9  # of an activity


def points_of(runs: "pd.DataFrame", split: str) -> "pd.DataFrame":
    """The points of all fronts under the conditions of a split: their means over the runs not lost.

    Args:
        runs: what :func:`~hydroservo.studies.columns.judged_columns` gives.
        split: such as ``validation``.

    Returns:
        The columns of ``GAINS``, ``lost`` (runs), ``error`` [SI] and ``activity`` [%/s], geometric means.
    """
    own = runs[runs["split"] == split]
    if own.empty:
        raise HydroservoError(f"the study's table: no {split} runs")
    logs = own.assign(error=np.log(own["error"]), activity=np.log(own["activity"].where(~own["lost"])))
    groups = logs.groupby(GAINS, observed=True, as_index=False)
    found = groups.agg({"lost": "sum", "error": "mean", "activity": "mean"})
    return found.assign(error=np.exp(found["error"]), activity=np.exp(found["activity"]))


def reference_points(points: "pd.DataFrame", reference: str, rules: Rules) -> "pd.DataFrame":
    """The point of the reference in each cell: the calmest of those that tie with its least error.

    Args:
        points: of all laws on validation.
        reference: the law.
        rules: whose margin makes a tie.
    """
    own = points[points["law"] == reference]
    fewest = own["lost"] == own.groupby("cell", observed=True)["lost"].transform("min")
    own = own[fewest]
    near = own["error"] <= rules.margin * own.groupby("cell", observed=True)["error"].transform("min")
    found = own[near].sort_values(["cell", "activity", *GAINS[2:]]).drop_duplicates("cell")
    lacking = sorted(set(points["cell"]) - set(found["cell"]))
    if lacking:
        problem = "loses all its runs, so it sets no activity to compare laws at; choose another reference"
        raise HydroservoError(f"cell {lacking[0]}: the reference, {reference}, {problem}")
    return found


def activities_of(points: "pd.DataFrame", reference: str, rules: Rules) -> dict[str, float]:
    """The activity of the reference in each cell [%/s], on validation."""
    found = reference_points(points, reference, rules)
    return {str(cell): float(one) for cell, one in zip(found["cell"], found["activity"], strict=True)}


def choose_gains(
    runs: "pd.DataFrame", reference: str, levels: Sequence[float], rules: Rules
) -> "pd.DataFrame":
    """The gains of each law at each level: of the points that are calm enough the one with the least error.

    That with the fewest lost runs on validation, of these the one with the least mean error, of these the
    calmest. A law without a point that is calm enough has none at that level.

    Args:
        runs: what :func:`~hydroservo.studies.columns.judged_columns` gives.
        reference: the law whose activity levels are multiples of.
        levels: they.
        rules: of the comparison.

    Returns:
        The columns of ``GAINS`` and ``level``, a row for each law, cell and level.
    """
    import pandas as pd

    points = points_of(runs, "validation")
    own = points["cell"].astype(str).map(activities_of(points, reference, rules))
    ordered = points.assign(multiple=points["activity"] / own).sort_values(
        ["law", "cell", "lost", "error", "activity", *GAINS[2:]]
    )
    parts = []
    for level in levels:
        calm = ordered[ordered["multiple"] <= level * (1.0 + ROUNDING)]
        parts.append(calm.drop_duplicates(["law", "cell"])[GAINS].assign(level=level))
    return pd.concat(parts, ignore_index=True).astype({"law": str, "cell": str})


def with_gains(choice: "pd.DataFrame", table: "pd.DataFrame") -> "pd.DataFrame":
    """The rows of a choice with the gains themselves, as JSON in the column ``parameters``.

    Args:
        choice: what :func:`choose_gains` gives.
        table: the study's.
    """
    return choice.merge(table[[*GAINS, "parameters"]].drop_duplicates(GAINS), on=GAINS)


def level_name(level: float) -> str:
    """A multiple of the reference's activity, as texts have it."""
    return f"{level:g}"
