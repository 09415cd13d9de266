"""Exported controllers give the bits of strict Python over random steps."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from hydroservo import Loop, Simulation
from hydroservo.core.block import leaves
from hydroservo.core.roles import Controller
from hydroservo.core.signals import Demand, Measurement
from hydroservo.engine import flat
from hydroservo.engine.compiling import compiled_function
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.examples import example
from hydroservo.testing.loops import signal_for
from tests.support.export.agreement import same_bits
from tests.support.needs import needs
from tests.support.roles import playing
from tests.support.tiers import mostly
from tools.targets.host import library
from tools.targets.laws import LAWS, PARTS, types_in
from tools.targets.sources import Rows

STEPS = 1_000_000
PERIOD = 1e-4
SCALES = (0.05, 200.0, 0.03, 4.0, 1e6, 1e6, 100.0, 0.05, 1.0, 30.0)  # of a measurement and a demand, SI


@cache
def signals(count: int) -> Rows:
    """Random measurements and demands: slow motion with noise, and jumps now and then."""
    draw = np.random.default_rng(7)
    slow = np.sin(np.arange(count)[:, None] * draw.uniform(1e-4, 1e-2, len(SCALES)))
    jumps = draw.normal(size=(count, len(SCALES))) * (draw.random((count, 1)) < 0.01)
    return np.asarray((slow + 0.1 * draw.normal(size=slow.shape) + 3.0 * jumps) * SCALES)


def steps(law: Controller, rows: Rows) -> Rows:
    """The states of a law after each row, by strictly compiled Python."""
    first = law.init()
    width = sum(1 for _ in leaves(first))
    store = flat.storer(first, lambda i: f"lane * {width} + {i}")

    def run(law, s, rows, out, dt):  # type: ignore[no-untyped-def]
        for k in range(rows.shape[0]):
            y = Measurement(
                rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4], rows[k, 5], rows[k, 6]
            )
            s = law.step(s, y, Demand(rows[k, 7], rows[k, 8], rows[k, 9]), dt)
            store(out, k, s)

    run.__module__ = flat.__name__  # whose functions may use memory
    out = np.empty(len(rows) * width)
    compiled_function(run)(law, first, rows, out, PERIOD)
    return out.reshape(-1, width)


def column(path: str) -> int:
    return (
        [f"measurement.{n}" for n in Measurement._fields].index(path)
        if path.startswith("m")
        else (len(Measurement._fields) + [f"demand.{n}" for n in Demand._fields].index(path))
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LAWS, ["PI", "TSMC implicit"]))
def test_a_million_random_steps_of_each_law(name: str, tmp_path: Path) -> None:
    needs("gcc")
    law, simulation = LAWS[name], Simulation(period=PERIOD, duration=1.0)
    loop = runnable_loop(example(Loop, simulation, controller=law, controls=signal_for(law)))
    unit = exported_unit(loop, Part.CONTROLLER, prefix="law", title=name)
    rows = signals(STEPS)
    given = [column(signal.path) for one in unit.arguments for signal in one.signals]
    states = library(unit, tmp_path).run(rows[:, given])
    names = [path for path, _ in leaves(loop.controller.init())]
    kept = [names.index(signal.path.removeprefix("controller.")) for signal in unit.states]
    expected = steps(loop.controller, rows)
    assert np.isfinite(expected).all()
    assert np.mean(np.abs(expected[:, 0]) < 9.9) > 0.05  # the command does not rest at its limits
    assert same_bits(np.ascontiguousarray(expected[:, kept]), states).all()


def test_every_part_of_a_controller_is_in_a_law() -> None:
    found = {cls for law in LAWS.values() for cls in types_in(law)}
    assert found >= {cls for role in PARTS for cls in playing(role)}
