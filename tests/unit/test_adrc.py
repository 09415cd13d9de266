"""Active disturbance rejection: its observer's published gains, its poles, and what it leaves."""

import math

import numpy as np
import pytest

from hydroservo import Loop, replace, simulate
from hydroservo.control.controlled import Position, Velocity
from hydroservo.control.controllers import PI, FirstOrderADRC, Saturation, SecondOrderADRC
from hydroservo.core.block import field_at
from hydroservo.core.signals import Demand, Measurement
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

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


def response(law: FirstOrderADRC, of: str, frequency: float, period: float) -> complex:
    """The command over the demand or over what is measured, at a frequency [rad/s], by the law's own step."""

    def after(x: np.ndarray, given: float) -> np.ndarray:
        s = law.init()._make(x.tolist())
        y = seen(given if of == "measured" else 0.0, s.u)
        return np.array(law.step(s, y, Demand(given if of == "demand" else 0.0, 0.0, 0.0), period))

    a = np.array([after(row, 0.0) for row in np.eye(3)]).T
    b = after(np.zeros(3), 1.0)
    z = np.exp(1j * frequency * period)
    return complex((z * np.linalg.solve(z * np.eye(3) - a, b))[0])


@pytest.mark.parametrize("w", [0.3, 5.0, 70.0, 900.0])
def test_order_one_is_a_pi_law_with_two_degrees_of_freedom_and_a_filter(w: float) -> None:
    """Herbst, Electronics 2(3), 2013, and arXiv:1908.04596: with l1 = 2 w_o, l2 = w_o^2 and a = w_c + l1

    C_y = ((w_c l1 + l2) s + w_c l2)/(b0 s (s + a)),   C_r = w_c (s^2 + l1 s + l2)/(b0 s (s + a)),

    in continuous time, by elimination from the observer; sampled it is off by the order of the period.
    """
    b0, w_c, w_o = 2.0, 20.0, 100.0
    s, l1, l2 = 1j * w, 2.0 * w_o, w_o * w_o
    below = b0 * s * (s + w_c + l1)
    law = first(b0, w_c, w_o)._replace(saturation=Saturation(1e9))
    exact = {
        "measured": -((w_c * l1 + l2) * s + w_c * l2) / below,
        "demand": w_c * (s * s + l1 * s + l2) / below,
    }
    for of, value in exact.items():
        off = [abs(response(law, of, w, h) / value - 1.0) for h in (1e-4, 1e-5)]
        assert off[1] < 0.01
        assert off[0] / off[1] == pytest.approx(10.0, rel=0.1)


def test_with_an_observer_that_is_quick_it_is_a_pi_law() -> None:
    """u_k - u_(k-1) = (r' - y' + w_c (r - y))/b0, as Fliess, Join, Int. J. Control 86(12), 2013, have it.

    The rates are differences, so k_p = 1/(b0 h) and k_i = w_c/(b0 h).
    """
    h, b0, w_c = 1e-3, 50.0, 30.0
    law, pi = first(b0, w_c, 1e6), PI(1.0 / (b0 * h), w_c / (b0 * h), controls=Velocity())
    draw = np.random.default_rng(5)
    y, r = np.cumsum(1e-3 * draw.normal(size=(2, 60)), axis=1)
    s, t = law.init(), pi.init()
    rows = []
    for k in range(60):
        demand = Demand(float(r[k]), float(r[k] - r[k - 1]) / h if k else 0.0, 0.0)
        s = law.step(s, seen(float(y[k]), s.u), demand, h)
        t = pi.step(t, seen(float(y[k]), t.u), demand, h)
        rows.append((s.u, t.u))
    ours, theirs = np.array(rows).T
    assert np.abs(theirs).max() < 10.0  # of the limit
    assert ours - ours[0] == pytest.approx(theirs - theirs[0], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("law", "units"), [(FirstOrderADRC, ("m/(s V)",)), (SecondOrderADRC, ("m/(s^2 V)",))]
)
def test_in_a_position_loop_units_are_those_of_a_position(law: type, units: tuple[str]) -> None:
    loop = example(Loop, controller=law(0.5, 20.0, 100.0), controls=Position())
    assert field_at(loop, "controller.input_gain").unit == units[0]


def integrators(order: int, b0: float, period: float) -> tuple[np.ndarray, np.ndarray]:
    """y' or y'' = b0 u under a held command: transition and input."""
    if order == 1:
        return np.ones((1, 1)), np.array([b0 * period])
    return np.array([[1.0, period], [0.0, 1.0]]), b0 * np.array([0.5 * period * period, period])


@pytest.mark.parametrize(("order", "kind"), [(1, FirstOrderADRC), (2, SecondOrderADRC)])
def test_a_position_loop_has_the_poles_of_law_and_observer(order: int, kind: type) -> None:
    """Around integrators, b0 known: w_c as state feedback has it, exp(-w_o h) of each state of the observer.

    One at 0 is left, of the command that the observer is told.
    """
    h, b0, w_c, w_o = 1e-3, 50.0, 100.0, 400.0
    law = kind(b0, w_c, w_o, saturation=Saturation(1e9), controls=Position())
    moved, driven = integrators(order, b0, h)

    def after(x: np.ndarray) -> np.ndarray:
        s = law.init()._make(x[order:].tolist())
        s = law.step(s, Measurement(NAN, NAN, float(x[0]), s.u, NAN, NAN, NAN), STILL, h)
        return np.concatenate([moved @ x[:order] + driven * s.u, s])

    size = order + len(law.init())
    found = np.linalg.eigvals(np.array([after(row) for row in np.eye(size)]).T)
    gain = np.array([w_c, 0.0] if order == 1 else [w_c * w_c, 2.0 * w_c])[:order] / b0
    of_law = np.linalg.eigvals(moved - np.outer(driven, gain))
    wanted = [0.0, *of_law, *[math.exp(-w_o * h)] * (order + 1)]
    assert np.poly(found) == pytest.approx(np.poly(wanted), abs=1e-10)


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
