"""How functions of many numbers change with each: exactly where their text says, else by differences."""

import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.twins import Twins

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Function = Callable[[Vector], Vector]
Rows = Callable[[Any, Sequence[Any]], Sequence[Any]]

NUDGE = 1e-5  # of each number's size
WIDE = 30.0  # times that
AGREED = 1e-4  # of a slope, by which differences may miss the exact one: their curvature
LEAST = 1e-6  # of the largest slope in a row, each by its number's size: their rounding


class Dual:
    """A number and its derivatives by some others, which every operation carries along.

    f(x + x' e) = f(x) + f'(x) x' e  with  e^2 = 0

    Comparisons are those of the numbers alone, so that a text takes the branch that it takes without slopes.

    Source: Griewank and Walther, Evaluating Derivatives, 2008, ch. 3 (the forward mode).
    Fails at kinks and jumps, where it has the slope of the branch that is taken; and where a text hands it to
    a function of a library, which takes no such number: with TypeError.
    """

    __slots__ = ("slopes", "value")
    __array_ufunc__ = None  # so that numpy's scalars leave operations to this class
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: float, slopes: Vector) -> None:
        self.value, self.slopes = value, slopes

    def __add__(self, other: Any) -> "Dual":
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.slopes + other.slopes)
        return Dual(self.value + float(other), self.slopes)

    __radd__ = __add__

    def __neg__(self) -> "Dual":
        return Dual(-self.value, -self.slopes)

    def __pos__(self) -> "Dual":
        return self

    def __sub__(self, other: Any) -> "Dual":
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> "Dual":
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> "Dual":
        if isinstance(other, Dual):
            slopes = scaled_slopes(other.value, self.slopes) + scaled_slopes(self.value, other.slopes)
            return Dual(self.value * other.value, slopes)
        return Dual(self.value * float(other), scaled_slopes(float(other), self.slopes))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Dual":
        if not isinstance(other, Dual):
            return Dual(self.value / float(other), self.slopes / float(other))
        found = self.value / other.value
        return Dual(found, (self.slopes - scaled_slopes(found, other.slopes)) / other.value)

    def __rtruediv__(self, other: Any) -> "Dual":
        found = float(other) / self.value
        return Dual(found, scaled_slopes(-found / self.value, self.slopes))

    def __pow__(self, other: float) -> "Dual":
        """As the text of blocks has it: a square, a cube."""
        return Dual(self.value**other, scaled_slopes(other * self.value ** (other - 1), self.slopes))

    def __abs__(self) -> "Dual":
        return -self if self.value < 0.0 else self

    def __int__(self) -> int:
        return int(self.value)

    def __bool__(self) -> bool:
        return self.value != 0.0

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < bare_number(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= bare_number(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > bare_number(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= bare_number(other))

    def __eq__(self, other: object) -> bool:
        return bool(self.value == bare_number(other))

    def __ne__(self, other: object) -> bool:
        return bool(self.value != bare_number(other))


def dual_twins() -> Twins:
    """What makes blocks equal to others, whose methods take numbers with slopes."""
    return Twins(dual_ops(), lambda value: value if isinstance(value, Dual) else float(value))


def bare_number(x: Any) -> Any:
    """A number without its slopes."""
    return x.value if isinstance(x, Dual) else x


def scaled_slopes(factor: float, slopes: Vector) -> Vector:
    """A factor times slopes; nothing stays nothing, whatever the factor."""
    return factor * slopes if math.isfinite(factor) else np.where(slopes == 0.0, 0.0, factor * slopes)


def with_slope(x: Any, value: float, slope: float) -> Any:
    """A function's value at a number, with the slope that it has there."""
    return Dual(value, scaled_slopes(slope, x.slopes)) if isinstance(x, Dual) else value


def dual_ops() -> SimpleNamespace:
    """The functions of :mod:`hydroservo.core.ops` by name, for numbers with slopes."""
    same = {name: getattr(ops, name) for name in ops.__all__}  # choices and comparisons are what they are
    smooth = {
        "absolute": abs,
        "copysign": dual_copysign,
        "sqrt": dual_sqrt,
        "floor": lambda x: ops.floor(bare_number(x)),
        "nearest": lambda x: with_slope(
            x, ops.nearest(bare_number(x)), 1.0
        ),  # a resolution, whose steps are small
        "square_wave": lambda t, period: ops.square_wave(bare_number(t), bare_number(period)),
        "power": dual_power,
        "signed_power": lambda x, y: dual_copysign(dual_power(abs(x), y), x),
        "power_root": dual_power_root,
        "smooth_root": lambda x, transition: x / dual_sqrt(dual_sqrt(x * x + transition * transition)),
        "sin": lambda x: with_slope(x, ops.sin(bare_number(x)), ops.cos(bare_number(x))),
        "cos": lambda x: with_slope(x, ops.cos(bare_number(x)), -ops.sin(bare_number(x))),
        "tanh": lambda x: with_slope(x, ops.tanh(bare_number(x)), 1.0 - ops.tanh(bare_number(x)) ** 2),
    }
    return SimpleNamespace(**same | smooth)


def dual_copysign(magnitude: Any, x: Any) -> Any:
    size = abs(magnitude)
    return -size if math.copysign(1.0, bare_number(x)) < 0.0 else size


def dual_sqrt(x: Any) -> Any:
    root = ops.sqrt(bare_number(x))
    return with_slope(x, root, 0.5 / root if root else math.inf)


def dual_power(x: Any, y: Any) -> Any:
    """x^y, by both: y x^(y - 1) and x^y ln x."""
    base, exponent = bare_number(x), bare_number(y)
    value = ops.power(base, exponent)
    found = with_slope(x, value, exponent * ops.power(base, exponent - 1.0))
    if isinstance(y, Dual) and base > 0.0:
        return found + Dual(0.0, scaled_slopes(value * math.log(base), y.slopes))
    return found


def dual_power_root(rhs: Any, linear: Any, factor: Any, a: float) -> Any:
    """The root s of linear s + factor s^a = rhs, by all but the exponent."""
    root = ops.power_root(bare_number(rhs), bare_number(linear), bare_number(factor), a)
    if root == 0.0:
        return 0.0
    powered = ops.power(root, a)
    slope = bare_number(linear) + a * bare_number(factor) * powered / root
    moved = (rhs - linear * root - factor * powered) / slope
    return with_slope(moved, root, 1.0)


class Slopes(NamedTuple):
    """The derivatives of a function, shape (values, numbers), and what they would be if found otherwise.

    Where the function has a slope all are the same but for its curvature; where it jumps, has a kink or goes
    in steps, they are not.
    """

    mean: Matrix  # exact where that is what central differences show too; these where not
    others: tuple[Matrix, Matrix, Matrix]  # by differences to either side, and by wider central ones
    error: Matrix  # of each in ``mean``; 0 where it is exact, else by how far the others are from it at most


def slopes(rows: Rows, block: Block, point: Vector, sizes: Vector) -> Slopes:
    """The derivatives of what blocks compute, at a point.

    The text of the blocks is evaluated once with numbers that carry their slopes. A kink at the point, of
    which that sees one side, and a text that takes no such numbers, are left to differences.

    Source: Griewank and Walther, Evaluating Derivatives, 2008, ch. 3.
    Fails to see a kink that lies beyond a nudge of 1e-5 of a number's size.
    """

    def function(numbers: Vector) -> Vector:
        return np.array(rows(block, numbers.tolist()))

    found = difference_slopes(function, point, sizes)
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

    Twins are of :func:`~hydroservo.linear.slopes.dual_twins`; those of a block's classes are made once.
    """
    with np.errstate(all="ignore"):
        try:
            numbers = [Dual(x, row) for x, row in zip(point.tolist(), np.eye(len(point)), strict=True)]
            values = rows(twins.of(block), numbers)
        except Exception:  # whatever a text does with a number that is none of Python's
            return None
    none = np.zeros(len(point))
    return np.array([value.slopes if isinstance(value, Dual) else none for value in values])


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def difference_slopes(function: Function, point: Vector, sizes: Vector) -> Slopes:
    """The derivatives at a point, by differences alone.

    What is not finite there is constant, and nothing changes with it.
    """
    here = function(point)
    after, before, far, back = (
        change_rates(function, here, point, scale * NUDGE * sizes) for scale in (1.0, -1.0, WIDE, -WIDE)
    )
    mean, others = 0.5 * (after + before), (after, before, 0.5 * (far + back))
    return Slopes(mean, others, np.max([np.abs(one - mean) for one in others], axis=0))


@np.errstate(all="ignore")  # what is lost is not finite, and refused as that
def central_slopes(function: Function, here: Vector, point: Vector, sizes: Vector) -> Matrix:
    """The mean in :func:`difference_slopes` alone, of a function whose values at the point are known."""
    after, before = (change_rates(function, here, point, side * NUDGE * sizes) for side in (1.0, -1.0))
    return 0.5 * (after + before)


def change_rates(function: Function, here: Vector, point: Vector, nudges: Vector) -> Matrix:
    """What each nudge changes, by the nudge, shape (values, numbers)."""
    known = np.isfinite(here)
    found = np.zeros((len(here), len(point)))
    for i in np.flatnonzero(np.isfinite(point)):
        there = point.copy()
        there[i] += nudges[i]
        found[known, i] = (function(there) - here)[known] / (there[i] - point[i])
    return found


def reachable_states(links: NDArray[np.bool_], first: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The states that are reached from some, where links[i, j] says that j moves i."""
    found = first
    for _ in first:
        found = found | (links @ found)
    return found
