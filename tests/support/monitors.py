"""Instants of a loop that was never run, for monitors to hear; and short loops that are."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import ArrayLike, NDArray

from hydroservo import Loop, Simulation
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.references import Square
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Pressures
from hydroservo.machine.loads import Constant, Sine
from hydroservo.machine.plants import Cylinder
from hydroservo.testing.examples import example

Floats = NDArray[np.float64]
STROKE = 0.078
DT = 2.0**-10  # exact, as are the random trajectories, so that no comparison hangs on rounding


def instant(**given: float) -> Any:
    """A state of a loop at an instant; all that is not given is 0."""
    known = dict.fromkeys(("velocity", "position", "pressure_a", "pressure_b", "demand", "rate", "u"), 0.0)
    known |= {"supply": 0.0} | given
    plant = SimpleNamespace(**{name: known[name] for name in tuple(known)[:4]})
    return SimpleNamespace(
        plant=plant,
        controlled=SimpleNamespace(value=known["velocity"]),
        reference=Demand(known["demand"], known["rate"], 0.0),
        controller=SimpleNamespace(u=known["u"]),
        supply=SimpleNamespace(pressure=known["supply"]),
    )


def loop_of(duration: float) -> Any:
    """What monitors ask of a loop whose command acts at once."""
    return SimpleNamespace(
        simulation=SimpleNamespace(duration=duration),
        plant=SimpleNamespace(stroke=STROKE),
        supply=SimpleNamespace(pressures=lambda s: Pressures(s.pressure, 0.0)),
        held=lambda s: s.controller.u,
        hold=SimpleNamespace(at=lambda held, _: held),
    )


def judged(monitor: Block, rows: Sequence[Any], dt: float = DT) -> Any:
    """What a monitor makes of instants dt apart, of which the last is the end."""
    last = len(rows) - 1
    m, loop = monitor.init(), loop_of(last * dt)
    for k, row in enumerate(rows):
        m = monitor.step(m, loop, row, k * dt, dt if k < last else 0.0)
    return monitor.values(m)


def instants(**columns: ArrayLike) -> list[Any]:
    """A row for each element of the columns."""
    table = np.stack(np.broadcast_arrays(*columns.values()), axis=1)
    return [instant(**dict(zip(columns, row, strict=True))) for row in table.tolist()]


def rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


COLUMNS = ("demand", "rate", "velocity", "u", "position", "pressure_a", "pressure_b")
numbers = st.integers(-4000, 4000).map(lambda n: 0.25 * n)
trajectories = st.integers(2, 40).flatmap(lambda n: arrays(np.float64, (n, len(COLUMNS)), elements=numbers))
SHORT = example(
    Loop,
    Simulation(duration=0.1, period=1e-3, substeps=2, record_period=1e-3),
    reference=example(Square),
    load=example(Constant),
    controller=PI(5.0, 500.0),
)
FULL = example(
    Loop,
    Simulation(duration=2e-3, period=1e-4, substeps=4, record_period=1e-4),
    plant=example(Cylinder),
    reference=Square(amplitude=3e-3, period=2e-3),
    load=Sine(50.0, 300.0),
    controller=example(TSMC),
)
