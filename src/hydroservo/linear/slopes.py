"""How a function of many numbers changes with each: exactly where its text says, else by differences."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block
from hydroservo.core.twins import Twins
from hydroservo.linear.duals import Dual, dual_twins, duals

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Function = Callable[[Vector], Vector]
Rows = Callable[[Any, Sequence[Any]], Sequence[Any]]

NUDGE = 1e-5  # of each number's size
WIDE = 30.0  # times that
AGREED = 1e-4  # of a slope, by which differences may miss the exact one: their curvature
LEAST = 1e-6  # of the largest slope in a row, each by its number's size: their rounding


class Slopes(NamedTuple):
    """The derivatives of a function, shape (values, numbers), and what they would be if found otherwise.

    Where the function has a slope all are the same but for its curvature; where it jumps, has a kink or goes
    in steps, they are not.

    Attributes:
        mean: exact where that is what central differences show too; these where not.
        others: by differences to either side, and by wider central ones.
        error: of each in ``mean``; 0 where it is exact, else by how far the others are from it at most.
    """

    mean: Matrix
    others: tuple[Matrix, Matrix, Matrix]
    error: Matrix


def slopes(rows: Rows, block: Block, point: Vector, sizes: Vector) -> Slopes:
    """The derivatives of what blocks compute, at a point.

    The text of the blocks is evaluated once with numbers that carry their slopes. A kink at the point, of
    which that sees one side, and a text that takes no such numbers, are left to differences.

    Args:
        rows: of a block and numbers; gives as many values each time.
        block: such as a loop; its twin is asked for exact slopes.
        point: where.
        sizes: of the numbers, by which they are nudged.

    Source: Griewank and Walther, Evaluating Derivatives, 2008, ch. 3.
    Fails to see a kink that lies beyond a nudge of 1e-5 of a number's size.
    """

    def function(numbers: Vector) -> Vector:
        return np.array(rows(block, numbers.tolist()))

    found = differences(function, point, sizes)
    exact = exact_slopes(rows, dual_twins(), block, point)
    if exact is None:
        return found
    with np.errstate(all="ignore"):
        share = np.abs(found.mean * sizes)
        room = AGREED * np.abs(exact) + LEAST * share.max(axis=1, initial=0.0)[:, np.newaxis] / sizes
        agreed = np.isfinite(exact) & (np.abs(found.mean - exact) <= room)
    return found._replace(mean=np.where(agreed, exact, found.mean), error=np.where(agreed, 0.0, found.error))


def exact_slopes(rows: Rows, twins: Twins, block: Block, point: Vector) -> Matrix | None:
    """The slopes of the branches that a text takes, shape (values, numbers); None where it has none.

    Twins are of :func:`~hydroservo.linear.duals.dual_twins`; those of a block's classes are made once.
    """
    with np.errstate(all="ignore"):
        try:
            values = rows(twins.of(block), duals(point))
        except Exception:  # whatever a text does with a number that is none of Python's
            return None
    none = np.zeros(len(point))
    return np.array([value.slopes if isinstance(value, Dual) else none for value in values])


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def differences(function: Function, point: Vector, sizes: Vector) -> Slopes:
    """The derivatives at a point, by differences alone.

    What is not finite there is constant, and nothing changes with it.

    Args:
        function: of an array of shape (numbers,); gives one of shape (values,).
        point: where.
        sizes: of the numbers, by which they are nudged.
    """
    here = function(point)
    after, before, far, back = (
        changes(function, here, point, scale * NUDGE * sizes) for scale in (1.0, -1.0, WIDE, -WIDE)
    )
    mean, others = 0.5 * (after + before), (after, before, 0.5 * (far + back))
    return Slopes(mean, others, np.max([np.abs(one - mean) for one in others], axis=0))


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def central(function: Function, here: Vector, point: Vector, sizes: Vector) -> Matrix:
    """The mean in :func:`differences` alone, of a function whose values at the point are known."""
    after, before = (changes(function, here, point, side * NUDGE * sizes) for side in (1.0, -1.0))
    return 0.5 * (after + before)


def changes(function: Function, here: Vector, point: Vector, nudges: Vector) -> Matrix:
    """What each nudge changes, by the nudge, shape (values, numbers)."""
    known = np.isfinite(here)
    found = np.zeros((len(here), len(point)))
    for i in np.flatnonzero(np.isfinite(point)):
        there = point.copy()
        there[i] += nudges[i]
        found[known, i] = (function(there) - here)[known] / (there[i] - point[i])
    return found


def reached(links: NDArray[np.bool_], first: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The states that are reached from some, where links[i, j] says that j moves i."""
    found = first
    for _ in first:
        found = found | (links @ found)
    return found
