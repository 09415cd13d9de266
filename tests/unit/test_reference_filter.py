"""The filter of a demand: its closed form, and what a law gains by it where the demand jumps."""

import numpy as np
import pytest

from hydroservo import replace, simulate
from hydroservo.control.controllers import PI, ReferenceFilter
from hydroservo.core.signals import Demand, Measurement
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

SEEN = Measurement(*[0.0] * 7)


def filtered(demands: list[float], w: float, h: float) -> np.ndarray:
    law = ReferenceFilter(example(PI), w)
    state, rows = law.init(), []
    for value in demands:
        state = law.step(state, SEEN, Demand(value, 0.0, 0.0), h)
        rows.append(state[1:4])
    return np.array(rows)


@pytest.mark.parametrize("h", [1e-3, 0.03])
def test_a_step_is_followed_as_three_poles_do_at_any_sample_period(h: float) -> None:
    w, n = 50.0, 20
    rows = filtered([0.0] + [1.0] * n, w, h)[1:]
    x = w * h * np.arange(1, n + 1)
    assert rows[:, 0] == pytest.approx(1.0 - np.exp(-x) * (1.0 + x + 0.5 * x * x), abs=1e-14)
    assert rows[:, 1] == pytest.approx(0.5 * w * x * x * np.exp(-x), rel=1e-11)
    assert rows[:, 2] == pytest.approx(w * w * np.exp(-x) * (x - 0.5 * x * x), rel=1e-9, abs=1e-9)


def test_it_starts_at_the_demand() -> None:
    assert filtered([0.7] * 3, 100.0, 1e-3) == pytest.approx(np.array([[0.7, 0.0, 0.0]] * 3), abs=1e-15)


@pytest.mark.slow  # compiles two loops
def test_a_law_spends_less_command_on_a_jump() -> None:
    loop = load_scenario("rig/1khz-tsmc-square")
    plain = simulate(loop)
    smooth = simulate(replace(loop, {"controller": ReferenceFilter(loop.controller, 200.0)}))
    assert float(smooth.control_total_variation) < 0.5 * float(plain.control_total_variation)
