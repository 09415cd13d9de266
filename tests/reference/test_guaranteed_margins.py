"""What a linear quadratic law is known to bear, and that an estimated state takes it away."""

import math

import numpy as np
import pytest

from hydroservo.control.synthesis.linear_model import model_at_rest
from hydroservo.control.synthesis.lqr import lqr
from hydroservo.control.synthesis.riccati import solution
from hydroservo.control.synthesis.sampled import under_held_input
from hydroservo.linear.margins import Margins, opened_loop_margins
from hydroservo.linear.system import OpenedLoop
from hydroservo.machine.plants import DesignModel
from hydroservo.testing.examples import example

PLANTS = {
    "double integrator": (np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0]), 1.0),
    "oil behind a valve": (*model_at_rest(example(DesignModel), 0.01).scaled()[:2], 1000.0),
}


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("effort", [0.1, 1.0, 10.0])
def test_a_fast_sampled_law_bears_half_its_gain_any_more_and_sixty_degrees(name: str, effort: float) -> None:
    """|1 + L| is never below 1 in continuous time: Anderson, Moore, Optimal Control, 1990, ch. 5."""
    rates, driven, speed = PLANTS[name]
    period = 1e-4 / speed
    moved, held = under_held_input(rates, driven, period)
    gain = lqr(moved, held, np.ones(len(held)), effort)
    found = opened_loop_margins(OpenedLoop(moved, held, -gain, period))
    assert found.stable
    assert found.sensitivity_peak == pytest.approx(1.0, abs=2e-3)
    assert found.gain_reduction_margin < 0.5 + 1e-3
    assert found.gain_margin > 100.0
    assert found.phase_margin > math.radians(60.0) - 1e-3


def estimating(weight: float, period: float = 1e-4) -> Margins:
    """Of Doyle's example, with the cost weight (x1 + x2)^2 + u^2, noise alike, and its filter in the loop."""
    moved, held = under_held_input(np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([0.0, 1.0]), period)
    driven, seen, all_alike = held[:, np.newaxis], np.array([[1.0, 0.0]]), weight * np.ones((2, 2)) * period
    x = solution(moved, driven, all_alike, np.array([[period]]))
    gain = np.linalg.solve(driven.T @ x @ driven + period, driven.T @ x @ moved)
    p = solution(moved.T, seen.T, all_alike, np.array([[1.0 / period]]))
    heard = moved @ p @ seen.T / (seen @ p @ seen.T + 1.0 / period)
    inside = moved - driven @ gain - heard @ seen
    whole = np.block([[moved, np.zeros((2, 2))], [heard @ seen, inside]])
    return opened_loop_margins(
        OpenedLoop(whole, np.append(held, [0.0, 0.0]), -np.append([0.0, 0.0], gain), period)
    )


@pytest.mark.parametrize("weight", [5.0, 60.0, 1000.0])
def test_with_an_estimated_state_no_margin_is_guaranteed(weight: float) -> None:
    """Doyle, IEEE Trans. Automatic Control 23(4), 1978: f (1, 1) and d (1, 1)' with f = d = 2 + sqrt(4 + q).

    A gain m on the command must keep 1 + (1 - m) d f and d + f - 4 + 2 (m - 1) d f above 0: necessary
    conditions, of which the first is where this loop ends.
    """
    found, f = estimating(weight), 2.0 + math.sqrt(4.0 + weight)
    assert found.stable
    assert found.gain_margin - 1.0 == pytest.approx(1.0 / (f * f), rel=0.02)
    assert 1.0 - found.gain_reduction_margin < (2.0 * f - 4.0) / (2.0 * f * f)
