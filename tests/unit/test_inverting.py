"""The frame of error dynamics and observer: what it is the same as, and where it is unstable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import replace, simulate
from hydroservo.control.controllers import Backstepping, Inverting
from hydroservo.control.error_dynamics import LinearErrorDynamics, SuperTwisting
from hydroservo.control.observers import (
    ExtendedStateObserver,
    HighGainObserver,
    KalmanObserver,
    ModelDerivative,
    NoObserver,
)
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

MODEL = example(DesignModel)
NAN = float("nan")
KALMAN = example(KalmanObserver)


def seen(velocity: float, hydraulic_force: float, command: float = 0.0) -> Measurement:
    return Measurement(velocity, hydraulic_force, NAN, command, NAN, NAN, NAN)


def command(law: Block, velocity: float, hydraulic_force: float, r: Demand) -> float:
    return float(law.step(law.init(), seen(velocity, hydraulic_force), r, 1e-3).u)


small = st.floats(-0.05, 0.05)


@given(small, st.floats(-500.0, 500.0), small, st.floats(-0.5, 0.5), st.floats(-5.0, 5.0))
def test_backstepping_is_feedback_linearisation_but_for_its_cross_term(
    velocity: float, hydraulic_force: float, value: float, rate: float, second: float
) -> None:
    k1, k2 = 300.0, 700.0
    r = Demand(value, rate, second)
    frame = Inverting(LinearErrorDynamics(k1, k2), NoObserver(), MODEL, ModelDerivative())
    stepping = Backstepping(k1, k2, MODEL)
    cross = -MODEL.g1() * (velocity - value) / MODEL.g2(hydraulic_force, 0.0)
    expected = command(frame, velocity, hydraulic_force, r) + cross
    expected = float(np.clip(expected, -10.0, 10.0))
    assert command(stepping, velocity, hydraulic_force, r) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def poles(law: Block, scale: float) -> np.ndarray:
    """Of the machine off its nominal parameters, with a static valve, under a law without memory."""
    loop = load_scenario("paper/sine-pi", {"uncertainty.scale": scale})
    plant, valve = loop.plant, loop.valve
    slope = [
        (command(law, x1, x2, Demand(0.0, 0.0, 0.0)) - command(law, -x1, -x2, Demand(0.0, 0.0, 0.0))) / 2.0
        for x1, x2 in ((1e-6, 0.0), (0.0, 1e-3))
    ]
    by_velocity, by_force = slope[0] / 1e-6, slope[1] / 1e-3
    gain = plant.flow_gain() * valve.orifice.flow_per_opening(loop.supply.drop()) * valve.gain
    rates = np.array(
        [
            [-plant.damping / plant.mass, 1.0 / plant.mass],
            [
                plant.free_force_rate(1.0, 0.0) + gain * by_velocity,
                plant.free_force_rate(0.0, 1.0) + gain * by_force,
            ],
        ]
    )
    return np.linalg.eigvals(rates)


def linearising(k: float) -> Inverting:
    return Inverting(LinearErrorDynamics(k, k), NoObserver(), MODEL, ModelDerivative())


def test_on_the_nominal_machine_the_poles_are_those_asked_for() -> None:
    law = Inverting(LinearErrorDynamics(200.0, 500.0), NoObserver(), MODEL, ModelDerivative())
    assert sorted(poles(law, 0.0).real) == pytest.approx([-500.0, -200.0], rel=1e-5)


@pytest.mark.parametrize(("scale", "forecast"), [(1.0, 382.63), (2.0, 517.70)])
def test_without_an_observer_stiffer_oil_is_unstable_below_a_gain(scale: float, forecast: float) -> None:
    """It cancels the nominal stiffness by positive feedback, through an input gain that has grown too.

    With the ratios of the true to the nominal input gain, gamma, and stiffness, beta, k^2 must exceed
    w_h^2 (gamma - beta)/gamma, but for the damping.
    """
    loop = load_scenario("paper/sine-pi", {"uncertainty.scale": scale})
    plant, valve = loop.plant, loop.valve
    gain = plant.flow_gain() * valve.orifice.flow_per_opening(loop.supply.drop()) * valve.gain / plant.mass
    gamma = gain / (MODEL.g2(0.0, 0.0) * MODEL.g1())
    stiffness, nominal = plant.free_force_rate(1.0, 0.0) / plant.mass, MODEL.f2(1.0, 0.0) * MODEL.g1()
    assert np.sqrt(-nominal * (gamma - stiffness / nominal) / gamma) == pytest.approx(forecast, abs=5e-3)
    assert poles(linearising(0.98 * forecast), scale).real.max() > 0.0
    assert poles(linearising(forecast), scale).real.max() < 0.0


@pytest.mark.parametrize("rate", [300.0, 30_000.0])
def test_a_disturbance_is_followed_by_its_rate_at_each_sample(rate: float) -> None:
    h, observer = 1e-6, HighGainObserver(rate, rate)  # short against the machine's own times
    d1, d2 = 4.0, 3e4
    state = observer.step(observer.init(), MODEL, seen(0.0, 0.0), h)
    x1, x2, share = 0.0, 0.0, []
    for _ in range(20):
        ahead = MODEL.ahead(x1, x2, 0.0, d1, d2, h)
        x1, x2 = ahead.velocity, ahead.hydraulic_force
        state = observer.step(state, MODEL, seen(x1, x2), h)
        share.append((state.d1 / d1, state.d2 / d2))
    expected = 1.0 - np.exp(-rate * h * np.arange(1, 21))
    assert np.array(share) == pytest.approx(np.column_stack([expected, expected]), rel=2e-3)


def test_the_gains_of_the_extended_state_observer_are_the_published_ones() -> None:
    """At h = 1 s and w = 1 rad/s: 0.864665 and 0.399576."""
    observer = ExtendedStateObserver(1.0, 1.0)
    state = observer.step(observer.init(), MODEL, seen(0.0, 0.0), 1e-9)
    kept = state._replace(velocity=0.0, hydraulic_force=0.0)
    z = float(np.exp(-1e-9))
    moved = observer.step(kept, MODEL, seen(1.0, 0.0), 1e-9)
    assert moved.velocity == pytest.approx(1.0 - z * z, rel=1e-6)
    assert moved.d1 * 1e-9 == pytest.approx((1.0 - z) ** 2, rel=1e-6)
    assert 1.0 - np.exp(-2.0) == pytest.approx(0.864665, abs=1e-6)


LAWS = {
    "linear, high gain": Inverting(LinearErrorDynamics(250.0, 250.0), HighGainObserver(300.0, 60.0)),
    "linear, extended state": Inverting(
        LinearErrorDynamics(250.0, 250.0), ExtendedStateObserver(400.0, 200.0)
    ),
    "linear, Kalman": Inverting(LinearErrorDynamics(250.0, 250.0), KALMAN),
    "super-twisting, Kalman": Inverting(SuperTwisting(200.0, 1e4), KALMAN),
}


@pytest.mark.slow  # each compiles a loop
@pytest.mark.parametrize("name", LAWS)
def test_in_the_paper_s_loop_an_observer_takes_the_load_s_error_away(name: str) -> None:
    loop = load_scenario("paper/sine-backstepping", {"simulation.duration": 1.0})
    found = simulate(replace(loop, {"controller": LAWS[name]}))
    assert not found.diverged
    bare = simulate(replace(loop, {"controller": linearising(250.0)}))
    assert float(found.steady_rms_error) < 0.05 * float(bare.steady_rms_error)
