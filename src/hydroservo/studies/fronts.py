"""The front of each law in each cell: what error it leaves at what activity, on the test conditions."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hydroservo.studies.ablation import Ratio
from hydroservo.studies.columns import GAINS
from hydroservo.studies.paired import exponentials, mean
from hydroservo.studies.pareto import on_front
from hydroservo.studies.rules import Rules
from hydroservo.studies.standing import geometric_mean
from hydroservo.studies.trials import Trials, trials_of

if TYPE_CHECKING:
    import pandas as pd


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
    ratio: Ratio
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

    Args:
        runs: what :func:`~hydroservo.studies.columns.judged_columns` gives.
        choice: what :func:`~hydroservo.studies.choice.choose_gains` gives.
        bases: the test runs of the reference at its own activity, by cell.
        rules: of the comparison.
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
            own = point(trials, bases[cell], levels.get(name, math.nan), rules)
            found[cell, law].points.append(own)
    cells: dict[str, dict[str, LawFront]] = {}
    for (cell, law), front in sorted(found.items()):
        cells.setdefault(cell, {})[law] = front._replace(points=members(front.points))
    return cells


def point(trials: Trials, base: Trials, level: float, rules: Rules) -> FrontPoint:
    """A point of a front, beside the reference at its own activity."""
    own = exponentials(mean(trials.logs(), rules.confidence))
    return FrontPoint(geometric_mean(trials.activity), *own, ratio_of(trials, base, rules), level)


def ratio_of(trials: Trials, base: Trials, rules: Rules) -> Ratio:
    """The error over another on the same conditions, where neither run was lost."""
    return Ratio(*exponentials(mean(trials.logs() - base.logs(), rules.confidence)))


def members(points: Sequence[FrontPoint]) -> list[FrontPoint]:
    """Those that no other beats, and those that validation chose; the calmest first."""
    ordered = sorted(points, key=lambda one: one.activity)
    front = on_front([(one.error, one.activity) for one in ordered])
    return [one for one, there in zip(ordered, front, strict=True) if there or not math.isnan(one.level)]
