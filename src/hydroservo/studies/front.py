"""What no other choice beats in all: the front of error, activity and robustness."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["Point", "on_front", "with_front"]


class Point(NamedTuple):
    """One law with one weight of effort in one cell, at the full budget on the test conditions.

    Attributes:
        law: its name.
        effort: the exponent of the command's activity in what was searched.
        error: as of a :class:`~hydroservo.studies.standing.Standing`.
        activity: likewise [%/s].
        survived: likewise.
        lost: the share of lost runs.
        front: whether no other point is as good in all and better in one, among those that lose no more than
            the rules allow.
    """

    law: str
    effort: float
    error: float
    activity: float
    survived: float
    lost: float
    front: bool


def with_front(points: Sequence[Point], most_lost: float) -> list[Point]:
    """Points of a cell, told which are on the front.

    Args:
        points: of all laws and efforts.
        most_lost: a point that loses a greater share of its runs is not on the front, and keeps no other from
            it.
    """
    running = [i for i, one in enumerate(points) if one.lost <= most_lost]
    costs = [(p.error, p.activity, 0.0 if np.isnan(p.survived) else -p.survived) for p in points]
    front = on_front([costs[i] for i in running])
    members = {i for i, member in zip(running, front, strict=True) if member}
    return [one._replace(front=i in members) for i, one in enumerate(points)]


def on_front(costs: ArrayLike) -> list[bool]:
    """Whether each row is on Pareto's front: no other is at most as large in all columns, and smaller in one.

    Args:
        costs: of shape (points, what is to be small).
    """
    rows = np.asarray(costs, dtype=np.float64)
    return [not ((rows <= row).all(axis=1) & (rows < row).any(axis=1)).any() for row in rows]
