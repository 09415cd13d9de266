"""Exported C gives the bits of strict Python: controllers over random steps, loops over whole runs."""

from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest
from benchmarks.targets.host import library
from benchmarks.targets.laws import LAWS, PARTS, types_in
from numpy.typing import NDArray

from compiling import compiled
from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.block import Block, Controller, leaves
from hydroservo.engine import flat
from hydroservo.export.exported import Part
from hydroservo.export.parts import Command, ControllerUnit, MachineUnit
from hydroservo.export.units import exported
from hydroservo.holds import DelayedHold
from hydroservo.scenario import builtin_scenarios, load_scenario
from hydroservo.signals import Demand, Measurement
from hydroservo.simulate import ready
from needs import needs
from roles import NOTHING, ROLES, blocks, playing
from strategies import choices

Rows = NDArray[np.float64]

STEPS = 1_000_000
PERIOD = 1e-4
SCALES = (0.05, 200.0, 0.03, 4.0, 1e6, 1e6, 0.05, 1.0, 30.0)  # of a measurement and a demand, SI
PERIODS = 200
LOOPS = 32  # of different blocks


@pytest.fixture(autouse=True, scope="module")
def compiler() -> None:
    needs("gcc")


def same_bits(a: Rows, b: Rows) -> NDArray[np.bool_]:
    """Where two arrays hold the same bits; all nan are one."""
    return (a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))


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
    store = compiled(flat.storer(first, lambda i: f"lane * {width} + {i}"))

    def run(law, s, rows, out, dt):  # type: ignore[no-untyped-def]
        for k in range(rows.shape[0]):
            y = Measurement(rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4], rows[k, 5])
            s = law.step(s, y, Demand(rows[k, 6], rows[k, 7], rows[k, 8]), dt)
            store(out, k, s)

    out = np.empty(len(rows) * width)
    compiled(run)(law, first, rows, out, PERIOD)
    return out.reshape(-1, width)


def column(path: str) -> int:
    return (
        [f"measurement.{n}" for n in Measurement._fields].index(path)
        if path.startswith("m")
        else (len(Measurement._fields) + [f"demand.{n}" for n in Demand._fields].index(path))
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_a_million_random_steps_of_each_law(name: str, tmp_path: Path) -> None:
    loop = ready(Loop(Simulation(period=PERIOD, duration=1.0), controller=LAWS[name]))
    unit = exported(loop, Part.CONTROLLER, prefix="law", title=name)
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


@pytest.mark.slow
@pytest.mark.parametrize("name", builtin_scenarios())
def test_built_in_scenarios(name: str, tmp_path: Path) -> None:
    assert_same_run(load_scenario(name), tmp_path, compiled=True)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["Tsit5", "Rosenbrock"])
def test_other_integrators(integrator: str, tmp_path: Path) -> None:
    changes = {"simulation.integrator.type": integrator, "simulation.duration": "0.5 s"}
    assert_same_run(load_scenario("rig/excavator-link", changes), tmp_path, compiled=True)


def assert_same_run(loop: Loop, folder: Path, *, compiled: bool) -> None:
    """A whole loop in C gives the bits of its strict simulation."""
    unit = exported(loop, Part.LOOP, prefix="loop", title="a loop")
    data = simulate(loop, strict=compiled, compiled=compiled)
    stride = round(loop.simulation.record_period / loop.simulation.period)
    count = data.sizes["time"]
    built = library(unit, folder)
    later = built.run(np.empty(((count - 1) * stride, 0)))[stride - 1 :: stride]
    rows = np.vstack([built.start(), later])
    for i, signal in enumerate(unit.states):
        if signal.path != "sample":
            assert same_bits(data[signal.path].values, np.ascontiguousarray(rows[:, i])).all(), signal.path
    paths = {path for path in data.data_vars if data[path].dims}
    assert paths == {signal.path for signal in unit.states} - {"sample"}


def picked(cls: type, draw: np.random.Generator) -> Block:
    """The default block of a class with a random choice for each role in it."""
    hints = get_type_hints(cls)
    inner = {}
    for name in cls._fields:
        if hints[name] in ROLES:
            found = choices(cls, hints[name])
            inner[name] = picked(found[draw.integers(len(found))], draw)
    return replace(cls(), inner)


def loop_of_choices(i: int) -> Loop:
    """A loop of random blocks, with each of the laws in turn."""
    simulation = Simulation(PERIODS * PERIOD, PERIOD, 2, PERIOD)
    law = list(LAWS.values())[i % len(LAWS)]
    loop = replace(picked(Loop, np.random.default_rng(i)), {"simulation": simulation, "controller": law})
    return replace(loop, {"hold.delay": 0.5 * PERIOD}) if isinstance(loop.hold, DelayedHold) else loop


@pytest.mark.slow
@pytest.mark.parametrize("i", range(LOOPS))
def test_loops_of_all_blocks(i: int, tmp_path: Path) -> None:
    assert_same_run(loop_of_choices(i), tmp_path, compiled=False)


def test_every_block_is_in_a_loop() -> None:
    found = {cls for i in range(LOOPS) for cls in types_in(loop_of_choices(i))}
    assert {cls for cls in blocks() if cls.__name__ not in NOTHING} <= found


def test_controller_and_machine_in_turn_are_the_loop() -> None:
    changes = {"simulation.duration": "0.2 s", "simulation.record_period": "1 ms"}
    loop = ready(load_scenario("rig/encoder-tsmc-sine", changes))
    period = loop.simulation.period
    controller, machine = ControllerUnit(loop.controller, period), MachineUnit(loop, period)
    state, s = controller.init(), machine.init()
    data = simulate(loop, compiled=False)
    for k in range(data.sizes["time"]):
        state = controller.step(state, s.measurement, loop.reference.at(k * period))
        for path, number in leaves(state):
            assert data[f"controller.{path}"].values[k] == number, path
        for part in ("plant", "valve", "sensors"):
            for path, number in leaves(getattr(s, part)):
                assert data[f"{part}.{path}"].values[k] == number, path
        s = machine.step(s, Command(state.u))
