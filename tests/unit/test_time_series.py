"""Recorded signals: what is refused, and what is made of two samples."""

import math
from typing import Any

import numpy as np
import pytest

from hydroservo.errors import ParameterError
from hydroservo.time_series import TimeSeries


@pytest.mark.parametrize(
    ("time", "value", "says"),
    [
        ([0.0], [1.0], "time = '1 samples': must be at least 2"),
        ([], [], "time = '0 samples': must be at least 2"),
        ([0.0, 1.0], [1.0], "value = '1 samples': must be as many as the 2 instants"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "time[2] = 1.0: must be after time[1] = 1 s"),
        ([0.0, 2.0, 1.0], [1.0, 2.0, 3.0], "time[2] = 1.0: must be after time[1] = 2 s"),
        ([0.0, math.nan], [1.0, 2.0], "time[1] = nan: must be a finite number"),
        ([0.0, math.inf], [1.0, 2.0], "time[1] = inf: must be a finite number"),
        ([0.0, 1.0], [-math.inf, 2.0], "value[0] = -inf: must be a finite number"),
        ([[0.0, 1.0]], [1.0, 2.0], "time = 'shape (1, 2)': must have one dimension"),
        (0.0, 1.0, "time = 'shape ()': must have one dimension"),
        ([0.0, "late"], [1.0, 2.0], "time = 'list': must be a one-dimensional array of numbers"),
        ([0.0, [1.0, 2.0]], [1.0, 2.0], "time = 'list': must be a one-dimensional array of numbers"),
        ([0.0, 1e-300], [0.0, 1e300], "value = 1e+300: overflows in the slopes between samples"),
    ],
)
def test_samples_that_make_no_signal(time: Any, value: Any, says: str) -> None:
    with pytest.raises(ParameterError) as error:
        TimeSeries.from_samples(time, value)
    assert str(error.value) == says


def test_two_samples_make_a_line() -> None:
    series = TimeSeries.from_samples([1.0, 3.0], [10.0, 14.0])
    assert [series.value(t) for t in (1.0, 1.5, 2.0, 3.0)] == pytest.approx([10.0, 11.0, 12.0, 14.0])
    assert [series.rate(t) for t in (1.0, 2.0, 3.0)] == pytest.approx([2.0, 2.0, 2.0])
    assert series.second_rate(2.0) == pytest.approx(0.0)


def test_the_record_ends_in_both_directions() -> None:
    series = TimeSeries.from_samples([1.0, 3.0], [10.0, 14.0])
    assert [series.value(t) for t in (0.0, 4.0)] == [10.0, 14.0]
    assert [series.rate(t) for t in (0.0, 4.0)] == [0.0, 0.0]
    assert [series.second_rate(t) for t in (0.0, 4.0)] == [0.0, 0.0]


def test_samples_may_be_integers_and_views() -> None:
    table = np.arange(10).reshape(5, 2)
    series = TimeSeries.from_samples(table[:, 0], table[:, 1])
    assert series.value(4.0) == 5.0
    assert all(array.flags.c_contiguous and array.dtype == np.float64 for array in series)


def test_the_record_is_a_copy() -> None:
    time = np.array([0.0, 1.0])
    series = TimeSeries.from_samples(time, time)
    time[:] = 7.0
    assert series.value(0.5) == 0.5


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 9, 1000])
def test_segment_is_the_last_knot_reached(n: int) -> None:
    series = TimeSeries.from_samples(np.arange(n), np.zeros(n))
    instants = np.arange(-0.5, n + 0.5, 0.25)
    found = [series.segment(float(t)) for t in instants]
    assert found == np.clip(np.floor(instants), 0, n - 2).tolist()


def test_not_a_number_is_no_instant() -> None:
    assert math.isnan(TimeSeries.from_samples([0.0, 1.0], [0.0, 1.0]).value(math.nan))
