"""An observer behind a slow valve: what it is told, what it hands on, and what d_L2 then is."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import replace, simulate
from hydroservo.control.controllers import Backstepping, Inverting
from hydroservo.control.error_dynamics import LinearErrorDynamics
from hydroservo.control.observers import Estimates, KalmanObserver, ValveLag
from hydroservo.control.wiring import believed
from hydroservo.core.block import Block
from hydroservo.core.hooks import designed
from hydroservo.core.signals import Measurement
from hydroservo.machine.plants import DesignModel
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

TAU, PERIOD = 0.01, 1e-3
MODEL = example(DesignModel)
KALMAN = KalmanObserver(10.0, 1e5, 5e-4, 5.0)
COMMANDS = (0.3, -0.1, 2.0, 2.0, -0.7)


class Echo(NamedTuple):
    """Hands on numbers of its own, and as d_L2 the command that it is told."""

    def init(self) -> Estimates:
        return Estimates(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, s: Estimates, model: Block, y: Measurement, dt: float) -> Estimates:
        return Estimates(1.0, 2.0, 3.0, y.command, y.velocity, y.hydraulic_force)


def seen(x1: float, x2: float, command: float) -> Measurement:
    return Measurement(x1, x2, math.nan, command, math.nan, math.nan, math.nan)


def test_the_nested_observer_is_told_the_mean_opening() -> None:
    observer, opening = ValveLag(Echo(), TAU), 0.0
    s = observer.init()
    for u in COMMANDS:

        def spool(t: float, x: np.ndarray, u: float = u) -> list[float]:
            return [(u - x[0]) / TAU, x[0] / PERIOD]

        opening, mean = solve_ivp(spool, (0.0, PERIOD), [opening, 0.0], rtol=1e-12, atol=1e-14).y[:, -1]
        s = observer.step(s, MODEL, seen(0.5, 60.0, u), PERIOD)
        assert s.d2 == pytest.approx(mean, rel=1e-9)
        assert s.opening == pytest.approx(opening, rel=1e-9)
        assert (s.s1, s.s2, s.d1, s.velocity, s.hydraulic_force) == (1.0, 2.0, 3.0, 0.5, 60.0)
        assert s.observer == (1.0, 2.0, 3.0, s.d2, 0.5, 60.0)


def test_the_nested_observer_is_designed() -> None:
    found = designed(ValveLag(KALMAN, TAU), PERIOD, lambda: MODEL).observer
    assert found == KALMAN.designed(MODEL, PERIOD)


def miss_of_the_oil(observer: Block, law: type) -> float:
    """The rms of what d2 is off the rate that the oil has besides the model under the true opening [N/s]."""
    loop = load_scenario("rig/1khz-pi-sine")
    gains = (100.0, 100.0) if law is Backstepping else (LinearErrorDynamics(100.0, 100.0),)
    loop = replace(loop, {"controller": law(*gains, observer=observer)})
    paths = (
        "controller.observer.d2",
        "disturbance.d2",
        "plant.hydraulic_force",
        "valve.opening",
        "controller.u",
    )
    run = simulate(loop, record=paths)
    model = believed(loop)
    d2, by_command, x2, opening, u = (run[path].values for path in paths)
    opening = opening / loop.valve.gain
    flow = np.array([model.g2(*pair) * pair[1] for pair in zip(x2, u, strict=True)])
    true = by_command + flow - [model.g2(*pair) * pair[1] for pair in zip(x2, opening, strict=True)]
    late = slice(len(u) // 2, None)
    return float(np.sqrt(np.mean((d2 - true)[late] ** 2)))


@pytest.mark.parametrize("law", [Backstepping, Inverting])
def test_d2_is_then_that_of_the_oil_alone(law: type) -> None:
    """On a valve of 10 ms, which no ValveInversion makes up for."""
    assert miss_of_the_oil(ValveLag(KALMAN, TAU), law) < 0.1 * miss_of_the_oil(KALMAN, law)


def test_the_lag_is_then_an_error_of_a_law_for_a_static_valve() -> None:
    """It is no disturbance any more, and nobody makes up for it."""
    loop = load_scenario("rig/1khz-pi-sine")
    laws = (Inverting(LinearErrorDynamics(100.0, 100.0), one) for one in (KALMAN, ValveLag(KALMAN, TAU)))
    plain, lagging = (float(simulate(replace(loop, {"controller": law})).rms_error) for law in laws)
    assert lagging > 2.0 * plain
