"""The machine under a held command against scipy's DOP853, an independent method at tight tolerance."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hydroservo import Loop, Simulation, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.loop import MachineState
from hydroservo.control.references import Sine
from hydroservo.core.block import Block, leaves
from hydroservo.engine.compiling import compiled_function
from hydroservo.machine.drives import ValveOnSupplyState
from hydroservo.machine.integrators import RK4
from hydroservo.machine.loads import Sine as SineLoad
from hydroservo.machine.supplies import IdealSupplyState
from hydroservo.machine.valves import FirstOrderValve, StaticValve
from hydroservo.testing.examples import example

DURATION, PERIOD, SUBSTEPS = 1.0, 1e-3, 50
TOLERANCE = 1e-8  # largest error over 1 s of each state, relative to its largest size
SIZES = {
    "plant.velocity": 0.03,
    "plant.hydraulic_force": 100.0,
    "plant.position": 0.04,
    "valve.opening": 1e-5,
}


@cache
def advance() -> Any:
    """One sample period of the classical Runge-Kutta method."""
    return compiled_function(RK4.advance)


def loop_with(valve: Block) -> Loop:
    """A loop whose command and load change sign, at different instants."""
    return example(
        Loop,
        simulation=Simulation(DURATION, PERIOD, 20, PERIOD),
        valve=valve,
        controller=PI(0.3, 100.0),
        reference=Sine(0.03, 1.0),
        load=SineLoad(100.0, 3.0),
    )


def by_runge_kutta(loop: Loop, commands: np.ndarray) -> np.ndarray:
    x = loop.machine(loop.init())
    states = [flat(x)]
    for k, u in enumerate(commands):
        x = advance()(RK4(), loop, k * PERIOD, x, float(u), PERIOD, SUBSTEPS)
        states.append(flat(x))
    return np.array(states)


def by_dop853(loop: Loop, commands: np.ndarray) -> np.ndarray:
    x = loop.machine(loop.init())
    plant, valve = type(x.plant), type(x.valve)
    paths = [path for path, _ in leaves(x)]
    absolute = [1e-15 * SIZES[path] for path in paths]

    def rates(t: float, y: np.ndarray, u: float) -> list[float]:
        return flat(
            loop.deriv(
                t,
                MachineState(
                    plant(*y[:3].tolist()), valve(*y[3:].tolist()), IdealSupplyState(), ValveOnSupplyState()
                ),
                u,
            )
        )

    states = [np.array(flat(x))]
    for k, u in enumerate(commands):
        span = (k * PERIOD, (k + 1) * PERIOD)
        done = solve_ivp(rates, span, states[-1], "DOP853", rtol=1e-12, atol=absolute, args=(float(u),))
        assert done.success
        states.append(done.y[:, -1])
    return np.array(states)


def flat(x: Block) -> list[float]:
    return [number for _, number in leaves(x)]


@pytest.mark.parametrize(
    "valve", [example(StaticValve), example(FirstOrderValve)], ids=lambda valve: type(valve).__name__
)
def test_agrees_with_dop853_restarted_at_each_sample(valve: Block) -> None:
    loop = loop_with(valve)
    run = simulate(loop, record=["controller.u"])
    commands = run["controller.u"].values[:-1]
    expected = by_dop853(loop, commands)
    error = np.abs(by_runge_kutta(loop, commands) - expected).max(axis=0) / np.abs(expected).max(axis=0)
    assert (error <= TOLERANCE).all(), error
