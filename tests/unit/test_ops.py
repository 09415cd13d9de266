"""The functions of ops at the points that matter; over all floats see the properties."""

import math

import pytest

from hydroservo import ops

NAN = math.nan


@pytest.mark.parametrize(
    ("x", "expected"), [(2.0, 1.0), (-1e-300, -1.0), (0.0, 0.0), (-0.0, 0.0), (NAN, 0.0)]
)
def test_sign(x: float, expected: float) -> None:
    assert ops.sign(x) == expected


@pytest.mark.parametrize(("a", "b", "low", "high"), [(1.0, 2.0, 1.0, 2.0), (NAN, 2.0, 2.0, 2.0)])
def test_minimum_and_maximum_take_the_second_where_they_do_not_compare(
    a: float, b: float, low: float, high: float
) -> None:
    assert ops.minimum(a, b) == low
    assert ops.maximum(a, b) == high


def test_where_takes_a_condition_and_two_values() -> None:
    assert ops.where(True, 1.0, 2.0) == 1.0
    assert ops.where(False, 1.0, 2.0) == 2.0


@pytest.mark.parametrize(
    ("x", "exponent", "expected"),
    [(32.0, 0.2, 2.0), (-32.0, 0.2, -2.0), (0.0, 5 / 7, 0.0), (-1.0, 5 / 7, -1.0)],
)
def test_signed_power_is_the_odd_root(x: float, exponent: float, expected: float) -> None:
    assert ops.signed_power(x, exponent) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("x", "transition", "expected"),
    [(4.0, 0.0, 2.0), (-4.0, 0.0, -2.0), (0.0, 0.0, 0.0), (-9e10, 1.0, -3e5), (1e-6, 4.0, 5e-7)],
)
def test_a_smooth_root_is_the_root_far_above_its_transition_and_linear_below(
    x: float, transition: float, expected: float
) -> None:
    assert ops.smooth_root(x, transition) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("t", "expected"), [(0.0, 1.0), (1.999, 1.0), (2.0, -1.0), (3.999, -1.0), (4.0, 1.0), (-0.5, -1.0)]
)
def test_square_wave_starts_with_plus(t: float, expected: float) -> None:
    assert ops.square_wave(t, 4.0) == expected


def test_square_wave_counts_a_sample_that_rounding_left_short() -> None:
    assert ops.square_wave(math.nextafter(2.0, 0.0), 4.0) == -1.0


def test_nothing_raises_where_python_does() -> None:
    assert math.isnan(ops.sqrt(-1.0))
    assert math.isnan(ops.sin(math.inf))
    assert ops.power(1e300, 2.0) == math.inf
    assert ops.power(0.0, -1.0) == math.inf
    assert ops.floor(-math.inf) == -math.inf
