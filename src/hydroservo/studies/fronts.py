"""The front of each law in each cell, and which point of it is taken at a level of activity."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.core.errors import HydroservoError
from hydroservo.studies.law_pairs import ErrorRatio
from hydroservo.studies.law_standing import known_geometric_mean
from hydroservo.studies.trials import GAINS, Rules, Trials, exponentials, mean_estimate, trials_of

if TYPE_CHECKING:
    import pandas as pd

Numbers = NDArray[np.float64]

STILL = 0.01  # a front that moves less by as many candidates again is still
MOST = float(np.log(2.0))  # by which a point of a front moves, where there was none before
CROSSOVER_INDEX, MUTATION_INDEX = 15.0, 20.0  # the larger, the nearer children are to their parents


def on_front(costs: ArrayLike) -> NDArray[np.bool_]:
    """Whether each row is on Pareto's front: no other is at most as large in all columns, and smaller in one.

    Args:
        costs: of shape (points, what is to be small).
    """
    rows = np.asarray(costs, dtype=np.float64)
    if not rows.size:
        return np.zeros(0, dtype=np.bool_)
    beaten: NDArray[np.bool_] = np.any(dominates(rows), axis=0)
    return ~beaten


def dominates(costs: Numbers) -> NDArray[np.bool_]:
    """Whether each row is at most as large as each other one in all columns, and smaller in one."""
    each = costs[:, np.newaxis]
    return np.logical_and((each <= costs).all(axis=2), (each < costs).any(axis=2))


def front_shift(before: Numbers, now: Numbers) -> float:
    """How far a front moved: by what its points are better, on average, than the front before them.

    Of each point it is the least by which some point of the front before it would have to be better in both.

    Args:
        before, now: points of shape (points, 2): logarithms of error and of activity.

    Source: Zitzler, Thiele, Laumanns, Fonseca, da Fonseca 2003, doi:10.1109/TEVC.2003.810758: the additive
    epsilon indicator, of each point in place of the worst one.
    """
    short = (before - now[:, np.newaxis]).max(axis=2).min(axis=1)
    return float(np.clip(short, 0.0, MOST).mean())


def evenly_spaced(points: Numbers, count: int) -> NDArray[np.int64]:
    """Members of a front at activities that are evenly spaced: of each, the one with the least error.

    Args:
        points: of shape (points, 2): logarithms of error and of activity.
        count: the most there are to be.
    """
    members = np.flatnonzero(on_front(points))
    own = points[members]
    at = np.linspace(own[:, 1].min(), own[:, 1].max(), count)
    calm = own[:, 1] <= at[:, np.newaxis] + 1e-12
    best = np.where(calm, own[:, 0], np.inf).argmin(axis=1)
    found: NDArray[np.int64] = members[np.unique(best)]
    return found


def offspring(units: Numbers, costs: Numbers, random: np.random.Generator) -> Numbers:
    """As many new points of the unit cube as there are, near those that are better or more alone.

    Parents are drawn in tournaments of two; children come from simulated binary crossover and polynomial
    mutation, and are reflected into the cube.

    Args:
        units: the points, shape (points, dimensions).
        costs: their two costs, shape (points, 2).
        random: the source of all draws.

    Source: Deb, Pratap, Agarwal, Meyarivan 2002, doi:10.1109/4235.996017; Deb and Agrawal 1995, Simulated
    binary crossover for continuous search space, Complex Systems 9, 115-148.
    """
    count = len(units)
    place = np.empty(count, dtype=np.int64)
    place[fittest(costs, count)] = np.arange(count)
    pairs = random.integers(count, size=(2, count))
    parents = units[np.where(place[pairs[0]] < place[pairs[1]], pairs[0], pairs[1])]
    return reflect(mutate(crossover(parents, random), random))


def crossover(parents: Numbers, random: np.random.Generator) -> Numbers:
    """Children of neighbouring parents, each number crossed in half of the cases."""
    one, other = parents, np.roll(parents, 1, axis=0)
    u = random.random(parents.shape)
    power = 1.0 / (CROSSOVER_INDEX + 1.0)
    spread = np.where(u <= 0.5, (2.0 * u) ** power, (0.5 / (1.0 - u)) ** power)
    child = 0.5 * ((1.0 + spread) * one + (1.0 - spread) * other)
    return np.where(random.random(parents.shape) < 0.5, child, one)


def mutate(children: Numbers, random: np.random.Generator) -> Numbers:
    """Children of which one number each, on average, has moved."""
    u = random.random(children.shape)
    power = 1.0 / (MUTATION_INDEX + 1.0)
    step = np.where(u < 0.5, (2.0 * u) ** power - 1.0, 1.0 - (2.0 * (1.0 - u)) ** power)
    return children + np.where(random.random(children.shape) < 1.0 / children.shape[1], step, 0.0)


def reflect(points: Numbers) -> Numbers:
    """Points inside the unit cube, folded at its faces."""
    return 1.0 - np.abs(1.0 - np.mod(points, 2.0))


def fittest(costs: Numbers, count: int) -> NDArray[np.int64]:
    """Which points are the best: by nondominated rank, then by crowding distance, the largest first.

    Args:
        costs: of shape (points, 2), finite.
        count: how many.
    """
    ranks = nondominated_ranks(costs)
    crowding = np.zeros(len(costs))
    for rank in range(int(ranks.max()) + 1):
        members = np.flatnonzero(ranks == rank)
        crowding[members] = crowding_distances(costs[members])
    return np.lexsort((-crowding, ranks))[:count]


def nondominated_ranks(costs: Numbers) -> NDArray[np.int64]:
    """The rank of each point: 0 on the front of all, 1 on that of those that are left without it, and on."""
    beats = dominates(costs)
    ranks = np.full(len(costs), -1)
    left, rank = np.ones(len(costs), dtype=np.bool_), 0
    while left.any():
        best = left & ~beats[left, :].any(axis=0)
        ranks[best] = rank
        left, rank = left & ~best, rank + 1
    return ranks


def crowding_distances(costs: Numbers) -> Numbers:
    """How far the neighbours of each point of a front are from each other; infinite at its ends."""
    found = np.zeros(len(costs))
    for own in costs.T:
        order = np.argsort(own, kind="stable")
        span = own[order[-1]] - own[order[0]]
        found[order[[0, -1]]] = np.inf
        if span > 0.0:
            found[order[1:-1]] += (own[order[2:]] - own[order[:-2]]) / span
    return found


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
