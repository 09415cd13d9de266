"""Numbers with slopes: the operations of blocks against mpmath's derivatives, and what has none."""

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from hydroservo import ops
from hydroservo.linear.slopes import Dual, dual_ops, slopes

TWIN = dual_ops()
FUNCTIONS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "quotient": (lambda x: (1.0 + x) / (x * x + 2.0) - 3.0 / x, lambda x: (1 + x) / (x * x + 2) - 3 / x),
    "cube": (lambda x: 2.0 - x**3, lambda x: 2 - x**3),
    "sqrt": (TWIN.sqrt, mpmath.sqrt),
    "power": (lambda x: TWIN.power(x, 0.3), lambda x: x ** mpmath.mpf(0.3)),
    "exponential": (lambda x: TWIN.power(2.5, x), lambda x: mpmath.mpf(2.5) ** x),
    "both": (lambda x: TWIN.power(x, x), lambda x: x**x),
    "signed power": (lambda x: TWIN.signed_power(-x, 0.7), lambda x: -(x ** mpmath.mpf(0.7))),
    "smooth root": (
        lambda x: TWIN.smooth_root(x, 0.1),
        lambda x: x / mpmath.root(x * x + mpmath.mpf(0.1) ** 2, 4),
    ),
    "sin": (TWIN.sin, mpmath.sin),
    "cos": (TWIN.cos, mpmath.cos),
    "tanh": (TWIN.tanh, mpmath.tanh),
    "absolute": (lambda x: TWIN.absolute(-x) * TWIN.copysign(2.0, x), lambda x: 2 * x),
    "choice": (lambda x: TWIN.where(x > 1.0, x * x, TWIN.maximum(x, 0.2)), lambda x: x * x if x > 1 else x),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("x", [0.3, 0.9, 1.7, 4.0])
def test_slopes_are_those_of_mpmath(name: str, x: float) -> None:
    ours, theirs = FUNCTIONS[name]
    found = ours(Dual(x, np.array([1.0])))
    with mpmath.workdps(40):
        value, slope = theirs(mpmath.mpf(x)), mpmath.diff(theirs, mpmath.mpf(x))
    assert found.value == pytest.approx(float(value), rel=1e-13)
    assert found.slopes[0] == pytest.approx(float(slope), rel=1e-12)


def test_every_operation_of_blocks_has_one() -> None:
    assert set(vars(TWIN)) == set(ops.__all__)


def test_a_root_of_two_powers_has_the_slopes_of_its_equation() -> None:
    """2 s + 3 s^0.4 = r: ds/dr = 1/(2 + 1.2 s^-0.6)."""
    found = TWIN.power_root(Dual(5.0, np.array([1.0])), 2.0, 3.0, 0.4)
    assert 2.0 * found.value + 3.0 * found.value**0.4 == pytest.approx(5.0, rel=1e-13)
    assert found.slopes[0] == pytest.approx(1.0 / (2.0 + 1.2 * found.value**-0.6), rel=1e-12)


def test_exact_slopes_are_taken_and_kinks_left_to_differences() -> None:
    """x^3 at 1, |x| and a jump at 0: the first is exact, the others say how much they may be off."""

    def rows(_: Any, numbers: Any) -> list[Any]:
        x, y = numbers
        absolute = abs if isinstance(y, Dual) else ops.absolute
        return [x * x * x, absolute(y), 1.0 if y >= 0.0 else 0.0, 3.0]

    found = slopes(rows, (), np.array([1.0, 0.0]), np.array([1.0, 1.0]))
    np.testing.assert_array_equal(found.mean[0], [3.0, 0.0])
    np.testing.assert_array_equal(found.error[0], [0.0, 0.0])
    assert found.mean[1, 1] == pytest.approx(0.0, abs=1e-9)
    assert found.error[1, 1] == pytest.approx(1.0)
    assert found.error[2, 1] > 1e4
    np.testing.assert_array_equal(found.mean[3], [0.0, 0.0])


def test_a_text_that_takes_no_such_numbers_is_left_to_differences() -> None:
    def rows(_: Any, numbers: Any) -> list[Any]:
        return [math.exp(numbers[0])]

    found = slopes(rows, (), np.array([0.5]), np.array([1.0]))
    assert found.mean[0, 0] == pytest.approx(math.exp(0.5), rel=1e-8)
    assert 0.0 < found.error[0, 0] < 1e-4
