"""How a function of many numbers changes with each, by differences that show where it has no slope."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Function", "Slopes", "reached", "slopes"]

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Function = Callable[[Vector], Vector]

NUDGE = 1e-5  # of each number's size
WIDE = 30.0  # times that


class Slopes(NamedTuple):
    """The derivatives of a function, shape (values, numbers), and what they would be if found otherwise.

    Where the function has a slope all are the same but for its curvature; where it jumps, has a kink or goes
    in steps, they are not.

    Attributes:
        mean: by central differences.
        others: by differences to either side, and by wider central ones.
    """

    mean: Matrix
    others: tuple[Matrix, Matrix, Matrix]


def slopes(function: Function, point: Vector, sizes: Vector) -> Slopes:
    """The derivatives at a point. What is not finite there is constant, and nothing changes with it.

    Args:
        function: of an array of shape (numbers,); gives one of shape (values,).
        point: where.
        sizes: of the numbers, by which they are nudged.
    """
    here = function(point)
    known = np.isfinite(here)
    nudges = NUDGE * sizes

    def table(scale: float) -> Matrix:
        """What each nudge changes, by the nudge, shape (values, numbers)."""
        found = np.zeros((len(here), len(point)))
        for i in np.flatnonzero(np.isfinite(point)):
            there = point.copy()
            there[i] += scale * nudges[i]
            found[known, i] = (function(there) - here)[known] / (there[i] - point[i])
        return found

    after, before = table(1.0), table(-1.0)
    wide = 0.5 * (table(WIDE) + table(-WIDE))
    return Slopes(0.5 * (after + before), (after, before, wide))


def reached(links: NDArray[np.bool_], first: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The states that are reached from some, where links[i, j] says that j moves i."""
    found = first
    for _ in first:
        found = found | (links @ found)
    return found
