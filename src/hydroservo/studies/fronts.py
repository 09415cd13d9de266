"""The front of each law in each cell, and which point of it is taken at a level of activity."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydroservo.core.errors import HydroservoError
from hydroservo.studies.law_pairs import ErrorRatio
from hydroservo.studies.law_standing import known_geometric_mean
from hydroservo.studies.pareto import on_front
from hydroservo.studies.trials import GAINS, Rules, Trials, exponentials, mean_estimate, trials_of

if TYPE_CHECKING:
    import pandas as pd

ROUNDING = 1e-9  # of an activity


def front_points(runs: "pd.DataFrame", split: str) -> "pd.DataFrame":
    """The points of all fronts under the conditions of a split: their means over the runs not lost.

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
    """The point of the reference in each cell: the calmest of those that tie with its least error."""
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
    calmest. A law without a point that is calm enough has none at that level. The columns are those of
    ``GAINS``, and ``level``.
    """
    import pandas as pd

    points = front_points(runs, "validation")
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
    """The rows of a choice with the gains themselves, as JSON in the column ``parameters``."""
    return choice.merge(table[[*GAINS, "parameters"]].drop_duplicates(GAINS), on=GAINS)


def level_name(level: float) -> str:
    """A multiple of the reference's activity, as texts have it."""
    return f"{level:g}"


class FrontPoint(NamedTuple):
    """A point of a law's front.

    Attributes:
        activity: of the command, geometric mean over the test conditions [%/s].
        error, error_low, error_high: the metric, likewise, with its interval over conditions [SI].
        ratio: the error over that of the reference at its own activity, on the same conditions.
        level: the smallest level at which validation chose this point; nan where it chose it at none.
    """

    activity: float
    error: float
    error_low: float
    error_high: float
    ratio: ErrorRatio
    level: float


class LawFront(NamedTuple):
    """The front of one law in one cell.

    Attributes:
        points: those that no other beats in error and activity on test, and those that are compared at a
            level; the calmest first.
        moved: how far the last half of the candidates moved the front, of the search that moved most.
    """

    points: list[FrontPoint]
    moved: float


def fronts_of(
    runs: "pd.DataFrame", choice: "pd.DataFrame", bases: Mapping[str, Trials], rules: Rules
) -> dict[str, dict[str, LawFront]]:
    """The fronts, by cell and law.

    A point with a lost run is on none. One that validation chose at a level stays where another one of its
    law beats it on test, for laws are compared by it.
    """
    levels = choice.groupby(GAINS, observed=True)["level"].min().to_dict()
    most = runs.groupby(["cell", "law"], observed=True, as_index=False)["moved"].max()
    columns = (most[name] for name in ("cell", "law", "moved"))
    found = {
        (str(cell), str(law)): LawFront([], float(moved)) for cell, law, moved in zip(*columns, strict=True)
    }
    for name, rows in runs[runs["split"] == "test"].groupby(GAINS, observed=True):
        law, cell = str(rows["law"].iloc[0]), str(rows["cell"].iloc[0])
        trials = trials_of(rows)
        if not trials.lost.any():
            own = front_point(trials, bases[cell], levels.get(name, math.nan), rules)
            found[cell, law].points.append(own)
    cells: dict[str, dict[str, LawFront]] = {}
    for (cell, law), front in sorted(found.items()):
        cells.setdefault(cell, {})[law] = front._replace(points=kept_points(front.points))
    return cells


def front_point(trials: Trials, base: Trials, level: float, rules: Rules) -> FrontPoint:
    """A point of a front, beside the reference at its own activity."""
    own = exponentials(mean_estimate(trials.logs(), rules.confidence))
    return FrontPoint(known_geometric_mean(trials.activity), *own, ratio_of(trials, base, rules), level)


def ratio_of(trials: Trials, base: Trials, rules: Rules) -> ErrorRatio:
    """The error over another on the same conditions, where neither run was lost."""
    return ErrorRatio(*exponentials(mean_estimate(trials.logs() - base.logs(), rules.confidence)))


def kept_points(points: Sequence[FrontPoint]) -> list[FrontPoint]:
    """Those that no other beats, and those that validation chose; the calmest first."""
    ordered = sorted(points, key=lambda one: one.activity)
    front = on_front([(one.error, one.activity) for one in ordered])
    return [one for one, there in zip(ordered, front, strict=True) if there or not math.isnan(one.level)]
