"""Numbers that carry their slopes: the text of blocks, evaluated with these, gives exact derivatives."""

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.core import ops
from hydroservo.core.twins import Twins

Vector = NDArray[np.float64]


class Dual:
    """A number and its derivatives by some others, which every operation carries along.

    f(x + x' e) = f(x) + f'(x) x' e  with  e^2 = 0

    Comparisons are those of the numbers alone, so that a text takes the branch that it takes without slopes.

    Args:
        value: the number.
        slopes: its derivatives, shape (numbers,).

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
            slopes = by(other.value, self.slopes) + by(self.value, other.slopes)
            return Dual(self.value * other.value, slopes)
        return Dual(self.value * float(other), by(float(other), self.slopes))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Dual":
        if not isinstance(other, Dual):
            return Dual(self.value / float(other), self.slopes / float(other))
        found = self.value / other.value
        return Dual(found, (self.slopes - by(found, other.slopes)) / other.value)

    def __rtruediv__(self, other: Any) -> "Dual":
        found = float(other) / self.value
        return Dual(found, by(-found / self.value, self.slopes))

    def __pow__(self, other: float) -> "Dual":
        """As the text of blocks has it: a square, a cube."""
        return Dual(self.value**other, by(other * self.value ** (other - 1), self.slopes))

    def __abs__(self) -> "Dual":
        return -self if self.value < 0.0 else self

    def __int__(self) -> int:
        return int(self.value)

    def __bool__(self) -> bool:
        return self.value != 0.0

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < plain(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= plain(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > plain(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= plain(other))

    def __eq__(self, other: object) -> bool:
        return bool(self.value == plain(other))

    def __ne__(self, other: object) -> bool:
        return bool(self.value != plain(other))


def dual_twins() -> Twins:
    """What makes blocks equal to others, whose methods take numbers with slopes."""
    return Twins(dual_ops(), lambda value: value if isinstance(value, Dual) else float(value))


def duals(numbers: Vector) -> list[Dual]:
    """Numbers, each with slope 1 by itself."""
    return [Dual(value, row) for value, row in zip(numbers.tolist(), np.eye(len(numbers)), strict=True)]


def plain(x: Any) -> Any:
    """A number without its slopes."""
    return x.value if isinstance(x, Dual) else x


def by(factor: float, slopes: Vector) -> Vector:
    """A factor times slopes; nothing stays nothing, whatever the factor."""
    return factor * slopes if math.isfinite(factor) else np.where(slopes == 0.0, 0.0, factor * slopes)


def along(x: Any, value: float, slope: float) -> Any:
    """A function's value at a number, with the slope that it has there."""
    return Dual(value, by(slope, x.slopes)) if isinstance(x, Dual) else value


def dual_ops() -> SimpleNamespace:
    """The functions of :mod:`hydroservo.core.ops` by name, for numbers with slopes."""
    same = {name: getattr(ops, name) for name in ops.__all__}  # choices and comparisons are what they are
    smooth = {
        "absolute": abs,
        "copysign": copysign,
        "sqrt": sqrt,
        "floor": steps(ops.floor),
        "nearest": lambda x: along(x, ops.nearest(plain(x)), 1.0),  # a resolution, whose steps are small
        "square_wave": lambda t, period: ops.square_wave(plain(t), plain(period)),
        "power": power,
        "signed_power": lambda x, y: copysign(power(abs(x), y), x),
        "power_root": power_root,
        "smooth_root": lambda x, transition: x / sqrt(sqrt(x * x + transition * transition)),
        "sin": lambda x: along(x, ops.sin(plain(x)), ops.cos(plain(x))),
        "cos": lambda x: along(x, ops.cos(plain(x)), -ops.sin(plain(x))),
        "tanh": lambda x: along(x, ops.tanh(plain(x)), 1.0 - ops.tanh(plain(x)) ** 2),
    }
    return SimpleNamespace(**same | smooth)


def steps(function: Callable[[float], float]) -> Callable[[Any], float]:
    """A function that is constant but for jumps."""
    return lambda x: function(plain(x))


def copysign(magnitude: Any, x: Any) -> Any:
    size = abs(magnitude)
    return -size if math.copysign(1.0, plain(x)) < 0.0 else size


def sqrt(x: Any) -> Any:
    root = ops.sqrt(plain(x))
    return along(x, root, 0.5 / root if root else math.inf)


def power(x: Any, y: Any) -> Any:
    """x^y, by both: y x^(y - 1) and x^y ln x."""
    base, exponent = plain(x), plain(y)
    value = ops.power(base, exponent)
    found = along(x, value, exponent * ops.power(base, exponent - 1.0))
    if isinstance(y, Dual) and base > 0.0:
        return found + Dual(0.0, by(value * math.log(base), y.slopes))
    return found


def power_root(rhs: Any, linear: Any, factor: Any, a: float) -> Any:
    """The root s of linear s + factor s^a = rhs, by all but the exponent."""
    root = ops.power_root(plain(rhs), plain(linear), plain(factor), a)
    if root == 0.0:
        return 0.0
    powered = ops.power(root, a)
    slope = plain(linear) + a * plain(factor) * powered / root
    moved = (rhs - linear * root - factor * powered) / slope
    return along(moved, root, 1.0)
