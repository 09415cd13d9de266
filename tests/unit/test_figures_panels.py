"""Which samples a panel shows, and the range of its axis."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.formatting import MINUS
from hydroservo.figures.panels import (
    WHOLE,
    Panel,
    SignalCurve,
    TimeWindow,
    clipped_text,
    curve_inside,
    range_with_margin,
)


def test_a_window_shows_its_samples_and_those_on_its_ends():
    curve = SignalCurve("x", np.arange(4.0), np.array([0.0, 1.0, 2.0, 99.0]), "k")
    assert curve_inside(curve, WHOLE).values.tolist() == [0.0, 1.0, 2.0, 99.0]
    assert curve_inside(curve, TimeWindow("", 1.0, 2.0)).time.tolist() == [1.0, 2.0]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40), st.floats(-1e6, 1e6))
def test_limits_hold_every_sample_and_leave_a_margin(values, other):
    low, high = range_with_margin([np.array(values), np.array([other, np.nan])], 0.0)
    assert low < min(*values, other) <= max(*values, other) < high


def test_limits_leave_spikes_out_and_say_so():
    values = np.sin(np.linspace(0.0, 20.0, 1000))
    values[[100, 500]] = [-80.0, 50.0]
    low, high = range_with_margin([values], 0.03)
    assert -1.5 < low < -1.0
    assert 1.0 < high < 1.5
    curve = SignalCurve("force", np.arange(1000.0), values, "k")
    panel = Panel("force", "N", [curve], fitted=["force"])
    assert clipped_text(panel) == f"clipped: force to {MINUS}80.0 N"
    assert clipped_text(panel._replace(fitted=())) == ""
    assert clipped_text(panel._replace(window=TimeWindow("", 0.0, 999.0))) == ""


def test_limits_of_nothing_finite_are_finite():
    assert range_with_margin([np.full(3, np.nan), np.array([])], 0.0) == (-1.0, 1.0)
