"""Active disturbance rejection: its observer's published gains, its poles, and what it leaves."""

import math

import numpy as np
import pytest

from hydroservo import replace, simulate
from hydroservo.controlled import Position, Velocity
from hydroservo.controllers import FirstOrderADRC, SecondOrderADRC
from hydroservo.scenario import load_scenario
from hydroservo.signals import Demand, Measurement

NAN = math.nan
STILL = Demand(0.0, 0.0, 0.0)


def seen(velocity: float, command: float = 0.0) -> Measurement:
    return Measurement(velocity, NAN, NAN, command, NAN, NAN, NAN)


def first(b0: float, w_c: float, w_o: float) -> FirstOrderADRC:
    return FirstOrderADRC(b0, w_c, w_o, controls=Velocity())


def second(b0: float, w_c: float, w_o: float) -> SecondOrderADRC:
    return SecondOrderADRC(b0, w_c, w_o, controls=Velocity())


def test_gains_of_order_one_are_the_published_ones() -> None:
    law = first(1.0, 1.0, 1.0)
    state = law.step(law.init()._replace(signal=0.0), seen(1.0), STILL, 1.0)
    assert (state.signal, state.disturbance) == pytest.approx((0.864665, 0.399576), abs=1e-6)


def test_gains_of_order_two_are_the_published_ones() -> None:
    law = second(1.0, 1.0, 1000.0)
    state = law.step(law.init()._replace(signal=0.0), seen(1.0), STILL, 1e-3)
    assert state.signal == pytest.approx(0.950213, abs=1e-6)
    assert state.rate == pytest.approx(819.8585, abs=1e-3)
    assert state.disturbance == pytest.approx(252580.46, abs=1e-1)


def test_on_an_integrator_with_b0_known_the_loop_has_its_pole() -> None:
    """The observer has nothing to correct there, so that its poles are not seen."""
    h, w_c = 1e-4, 40.0
    law, y, u = first(2.0, w_c, 400.0), 0.1, 0.0
    state, rows = law.init(), []
    for _ in range(1000):
        state = law.step(state, seen(y, u), STILL, h)
        rows.append(y)
        u = state.u
        y += h * 2.0 * u
    kept = np.array(rows[1:]) / np.array(rows[:-1])
    assert kept == pytest.approx(1.0 - w_c * h, rel=1e-12)


def test_on_a_double_integrator_with_b0_known_the_loop_has_its_poles() -> None:
    h, w_c, b0 = 1e-5, 40.0, 2.0
    law, y, rate, u = second(b0, w_c, 4000.0), 0.0, 0.0, 0.0
    state, rows = law.init(), []
    for k in range(20_000):
        turn = 5.0 * k * h
        r = Demand(0.01 * math.sin(turn), 0.05 * math.cos(turn), -0.25 * math.sin(turn))
        state = law.step(state, seen(y, u), r, h)
        rows.append(r.value - y)
        u = state.u
        y, rate = y + h * rate + 0.5 * h * h * b0 * u, rate + h * b0 * u
    t = h * np.arange(len(rows))
    exact = 0.05 * t * np.exp(-w_c * t)  # from the rate that is missing at the start
    assert np.abs(np.array(rows) - exact).max() < 5e-3 * exact.max()


@pytest.mark.parametrize("make", [first, second])
def test_a_load_that_stays_leaves_no_error(make: type) -> None:
    h, push, y, rate, u = 1e-3, 7.0, 0.0, 0.0, 0.0
    law = make(2.0, 20.0, 100.0)
    state = law.init()
    for _ in range(5000):
        state = law.step(state, seen(y, u), STILL, h)
        u = state.u
        if make is first:
            y += h * (2.0 * u + push)
        else:
            y, rate = y + h * rate + 0.5 * h * h * (2.0 * u + push), rate + h * (2.0 * u + push)
    assert abs(y) < 1e-12
    assert state.disturbance == pytest.approx(push, rel=1e-9)


def test_nothing_winds_up_at_the_limit() -> None:
    h, y, u = 1e-3, 0.0, 0.0
    law = first(2.0, 20.0, 100.0)
    state = law.init()
    for _ in range(3000):  # a demand out of reach
        state = law.step(state, seen(y, u), Demand(1e3, 0.0, 0.0), h)
        u = state.u
        y += h * 2.0 * u
    assert u == 10.0
    assert abs(state.disturbance) < 1e-6


@pytest.mark.slow  # each compiles a loop
@pytest.mark.parametrize("scale", [-1.0, 0.0, 1.0])
def test_order_one_follows_on_the_rig(scale: float) -> None:
    loop = load_scenario("rig/1khz-pi-sine", {"uncertainty.scale": scale})
    found = simulate(replace(loop, {"controller": FirstOrderADRC(244.0, 460.0, 2600.0)}))
    assert not found.diverged
    assert float(found.rms_error) < float(simulate(loop).rms_error)


@pytest.mark.slow  # compiles a loop
def test_order_two_closes_a_position_loop() -> None:
    loop = load_scenario("axis/position")
    law = SecondOrderADRC(49.4, 297.0, 888.0, controls=Position())
    found = simulate(replace(loop, {"controller": law}))
    assert not found.diverged
    assert float(found.rms_error) < 1e-4
