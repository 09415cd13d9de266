"""Loops and parameters with which threads of CUDA are compared with single runs."""

from typing import Any

import numpy as np

from hydroservo import Loop, Simulation, monitors
from hydroservo.control.controllers import DAC, PI, TSMC, AntiWindup, Backstepping, RateLimit
from hydroservo.control.holds import DelayedHold
from hydroservo.control.observers import Explicit, Implicit, ModelDerivative, TSMObserver
from hydroservo.control.references import Chirp, Multisine, Recorded, Square
from hydroservo.core.group import group
from hydroservo.core.time_series import TimeSeries
from hydroservo.machine.integrators import Tsit5
from hydroservo.machine.loads import Recorded as RecordedLoad
from hydroservo.machine.loads import Square as SquareLoad
from hydroservo.machine.sensors import DelayedSensors, Dropout, ExactDifferentiator, NoisySensors, RigSensors
from hydroservo.machine.valves import CurvedEdges, FirstOrderValve, FourEdges, StaticValve
from hydroservo.testing.examples import example

PRESSURES = "ChamberPressures"  # a cylinder's, whose parameters have other names
TIME = np.linspace(0.0, 2e-3, 6)
LOOPS = {
    "tsmc": example(
        Loop,
        Simulation(1e-3, 1e-4, 2),
        controller=example(TSMC, observer=example(TSMObserver, realisation=Implicit())),
    ),
    "tsmc-explicit": example(
        Loop,
        Simulation(1e-3, 1e-4),
        reference=example(Multisine),
        controller=example(
            TSMC, observer=example(TSMObserver, realisation=Explicit()), derivative=ModelDerivative()
        ),
    ),
    "backstepping-recorded": example(
        Loop,
        Simulation(2e-3, 2e-4),
        reference=Recorded(TimeSeries.from_samples(TIME, 0.03 * np.sin(1e3 * TIME))),
        load=RecordedLoad(TimeSeries.from_samples(TIME[[0, 2, 5]], 1e6 * TIME[[0, 2, 5]])),
        controller=example(Backstepping),
    ),
    "pi-noise": example(
        Loop,
        Simulation(1e-3, 1e-4),
        valve=example(FirstOrderValve),
        sensors=example(NoisySensors),
        reference=example(Square),
        controller=example(PI),
    ),
    "rig": example(
        Loop,
        Simulation(1e-3, 1e-4, 2),
        sensors=Dropout(0.3, DelayedSensors(example(RigSensors, velocity=example(ExactDifferentiator)))),
        controller=example(AntiWindup, DAC(example(RateLimit, example(PI)))),
        hold=DelayedHold(5e-5),
    ),
    "notches": example(
        Loop,
        Simulation(1e-3, 1e-4),
        valve=example(StaticValve, orifice=example(FourEdges, shape=example(CurvedEdges), clearance=2e-6)),
        reference=example(Square),
        controller=example(PI),
    ),
    "tsit5": example(
        Loop,
        Simulation(6e-4, 1e-4, integrator=Tsit5(1e-6)),
        load=example(SquareLoad, period=3e-4),
        reference=example(Chirp),
        controller=example(PI),
    ),
    "every-metric": example(
        Loop,
        Simulation(4e-4, 1e-4, 2),
        reference=example(Square, period=3e-4),
        controller=example(TSMC),
        metrics=group(
            {name: example(getattr(monitors, name)) for name in monitors.__all__ if name != PRESSURES}
        ),
    ),
}
RANGES = {
    "plant.bulk_modulus": (3e8, 2e9),
    "plant.start_position": (0.0, 0.078),
    "controller.saturation.limit": (1e-3, 10.0),
}


def drawn(runs: int, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    seeds = rng.integers(0, 2**53, runs, endpoint=False)
    return {path: rng.uniform(*limits, runs) for path, limits in RANGES.items()} | {"simulation.seed": seeds}


def diverging() -> tuple[Loop, dict[str, Any]]:
    """A loop and parameters of which the second makes its run diverge."""
    loop = example(
        Loop, Simulation(1e-3, 1e-4), valve=example(StaticValve, max_opening=1e300), reference=example(Square)
    )
    gains, limits = np.array([100.0, 1e308, 90.0]), np.full(3, 1e300)
    return loop, {"controller.proportional_gain": gains, "controller.saturation.limit": limits}
