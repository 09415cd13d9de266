"""Which margins of a loop are given, by what is known of its onset of oscillation."""

import math

import numpy as np
import pytest

from hydroservo import load_scenario, replace
from hydroservo.control.loop import Loop
from hydroservo.linear.moving_margins import (
    TrustedMargins,
    agrees_with_onset,
    crossed_phase_margin,
    trusted_margins,
    without_hysteresis,
)
from hydroservo.linear.view import smoothest_point
from hydroservo.runs.arguments import checked_loop
from tests.support.brink import at_the_brink


def trusted(loop: Loop, onset: float, command: float | None = None) -> TrustedMargins:
    loop = checked_loop(loop)
    point, judged, _ = smoothest_point(loop, command, None)
    return trusted_margins(point, judged, loop, onset)


@pytest.mark.parametrize(
    ("margin", "onset", "said"),
    [
        (2.0, 2.0, True),
        (2.0, 2.0 * 10.0 ** (1.4 / 20.0), True),
        (2.0, 2.0 * 10.0 ** (1.6 / 20.0), False),
        (2.0, math.inf, False),
        (30.0, math.inf, True),  # both above 20 dB
        (math.inf, math.inf, True),
        (math.nan, 2.0, False),
        (2.0, math.nan, True),
    ],
)
def test_a_gain_margin_agrees_with_an_onset_within_a_decibel_and_a_half(
    margin: float, onset: float, said: bool
) -> None:
    assert agrees_with_onset(margin, onset) is said


def test_a_smooth_loop_whose_runs_agree_has_its_own_margins() -> None:
    found = trusted(load_scenario("rig/1khz-pi-sine"), 2.0)
    assert found.here
    assert found.remark == ""
    assert found.margins.gain_margin == pytest.approx(1.916, abs=1e-3)


def test_rest_in_an_overlap_does_not_count_even_where_no_onset_is_known() -> None:
    loop = replace(at_the_brink("axis/position"), {"valve.hysteresis": 0.0})
    found = trusted(loop, math.nan)
    assert not found.here
    assert 20.0 * math.log10(found.margins.gain_margin) == pytest.approx(1.35, abs=0.05)
    assert "24.8" not in found.remark


def test_a_law_without_slopes_has_no_margins_and_names_what_takes_them() -> None:
    found = trusted(load_scenario("paper/sine-tsmc"), math.inf)
    assert math.isnan(found.margins.gain_margin)
    assert "TSMC" in found.remark
    assert "measure with a larger amplitude" in found.remark
    assert "the valve's hysteresis" in trusted(at_the_brink("axis/position-adrc"), 1.5).remark


def test_only_hysteresis_slides() -> None:
    loop = load_scenario("axis/position")
    assert without_hysteresis(loop) == replace(loop, {"valve.hysteresis": 0.0})


def test_a_response_of_0_has_no_phase_and_no_warning() -> None:
    assert crossed_phase_margin(np.array([0.0, 0.0, 0.0], dtype=complex)) == math.pi
    halves = np.array([0.0, 2.0j, -0.5j])  # from +90 to -90 degrees by way of 0: nearest to -180 in between
    assert 0.0 <= crossed_phase_margin(halves) <= math.pi
