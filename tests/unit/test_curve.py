"""Curves: what is refused, and what is made of two points."""

import math
from typing import Any

import numpy as np
import pytest

from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.time_series import TimeSeries


@pytest.mark.parametrize(
    ("x", "y", "says"),
    [
        ([0.0], [1.0], "x = '1 samples': must be at least 2"),
        ([], [], "x = '0 samples': must be at least 2"),
        ([0.0, 1.0], [1.0], "y = '1 samples': must be as many as the 2 of x"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "x[2] = 1.0: must be above x[1] = 1"),
        ([0.0, 2.0, 1.0], [1.0, 2.0, 3.0], "x[2] = 1.0: must be above x[1] = 2"),
        ([0.0, math.nan], [1.0, 2.0], "x[1] = nan: must be a finite number"),
        ([0.0, math.inf], [1.0, 2.0], "x[1] = inf: must be a finite number"),
        ([0.0, 1.0], [-math.inf, 2.0], "y[0] = -inf: must be a finite number"),
        ([[0.0, 1.0]], [1.0, 2.0], "x = 'shape (1, 2)': must have one dimension"),
        (0.0, 1.0, "x = 'shape ()': must have one dimension"),
        ([0.0, "late"], [1.0, 2.0], "x = 'list': must be a one-dimensional array of numbers"),
        ([0.0, [1.0, 2.0]], [1.0, 2.0], "x = 'list': must be a one-dimensional array of numbers"),
        ([0.0, 1e-300], [0.0, 1e300], "y = 1e+300: overflows in the slopes between samples"),
    ],
)
def test_samples_that_make_no_signal(x: Any, y: Any, says: str) -> None:
    with pytest.raises(ParameterError) as error:
        Curve.from_samples(x, y)
    assert str(error.value) == says


def test_two_samples_make_a_line() -> None:
    series = Curve.from_samples([1.0, 3.0], [10.0, 14.0])
    assert [series.value(t) for t in (1.0, 1.5, 2.0, 3.0)] == pytest.approx([10.0, 11.0, 12.0, 14.0])
    assert [series.rate(t) for t in (1.0, 2.0, 3.0)] == pytest.approx([2.0, 2.0, 2.0])
    assert series.second_rate(2.0) == pytest.approx(0.0)


def test_the_record_ends_in_both_directions() -> None:
    series = Curve.from_samples([1.0, 3.0], [10.0, 14.0])
    assert [series.value(t) for t in (0.0, 4.0)] == [10.0, 14.0]
    assert [series.rate(t) for t in (0.0, 4.0)] == [0.0, 0.0]
    assert [series.second_rate(t) for t in (0.0, 4.0)] == [0.0, 0.0]


def test_samples_may_be_integers_and_views() -> None:
    table = np.arange(10).reshape(5, 2)
    series = Curve.from_samples(table[:, 0], table[:, 1])
    assert series.value(4.0) == 5.0
    assert all(array.flags.c_contiguous and array.dtype == np.float64 for array in series)


def test_the_record_is_a_copy() -> None:
    time = np.array([0.0, 1.0])
    series = Curve.from_samples(time, time)
    time[:] = 7.0
    assert series.value(0.5) == 0.5


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 9, 1000])
def test_segment_is_the_last_knot_reached(n: int) -> None:
    series = Curve.from_samples(np.arange(n), np.zeros(n))
    instants = np.arange(-0.5, n + 0.5, 0.25)
    found = [series.segment(float(t)) for t in instants]
    assert found == np.clip(np.floor(instants), 0, n - 2).tolist()


def test_not_a_number_is_no_instant() -> None:
    assert math.isnan(Curve.from_samples([0.0, 1.0], [0.0, 1.0]).value(math.nan))


def test_a_time_series_is_a_curve() -> None:
    assert TimeSeries is Curve


def test_the_samples_of_a_curve_are_its_points() -> None:
    y = [0.0, 0.4, 1.2, 7.0]
    assert Curve.from_samples([0.0, 0.1, 0.2, 0.5], y).samples.tolist() == pytest.approx(y, rel=1e-15)


def test_a_curve_does_not_leave_what_its_points_are_between() -> None:
    curve = Curve.from_samples([0.0, 0.2, 0.4, 1.0], [0.0, 0.0, 1.0, 1.0])
    values = [curve.value(x) for x in np.linspace(0.0, 1.0, 501)]
    assert values[:101] == [0.0] * 101
    assert (np.diff(values) >= 0.0).all()
    assert values[200:] == [1.0] * 301
