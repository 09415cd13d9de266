"""Fronts of error and command activity: the points that no other beats in both."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Numbers = NDArray[np.float64]

STILL = 0.01  # a front that moves less by as many candidates again is still
MOST = float(np.log(2.0))  # by which a point of a front moves, where there was none before


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
