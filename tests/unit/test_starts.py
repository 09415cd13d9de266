"""Where runs start: states that are given, and machines that have settled."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from scipy.optimize import least_squares

from hydroservo import (
    Field,
    Loop,
    ParameterError,
    ScenarioError,
    Simulation,
    load_scenario,
    replace,
    simulate,
    simulate_batch,
)
from hydroservo.core.block import Block, field_at, leaves, value_at, values
from hydroservo.core.group import group, nested
from hydroservo.core.roles import Start, role
from hydroservo.core.states import filled
from hydroservo.machine.loads import Constant
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.starts import AsBuilt, Steady
from hydroservo.machine.valves import FirstOrderValve, FourEdges, SecondOrderValve, StaticValve
from hydroservo.runs.columns import start_columns
from hydroservo.runs.run import prepare_loop, runnable_loop
from hydroservo.runs.steady import state_sizes, steady_state
from hydroservo.testing.examples import example
from tests.support.monitors import SHORT

BRIEF = Simulation(duration=5e-3, period=1e-3, substeps=2, record_period=1e-3)
EDGES = example(FourEdges, clearance=2e-6)


def settled(loop: Loop, command: float = 0.0) -> tuple[Loop, object]:
    loop = runnable_loop(loop)
    return loop, steady_state(loop, command)


def test_given_states_are_where_a_run_starts() -> None:
    given = {"plant.velocity": 0.01, "controller.integral": 0.25}
    data = simulate(SHORT._replace(start=AsBuilt(nested(given))), strict=True)
    plain = simulate(SHORT._replace(start=AsBuilt(nested(given))), compiled=False)
    assert data["plant.velocity"].values[0] == 0.01
    demand = float(data["reference.value"][0])
    assert data["controller.integral"].values[0] == pytest.approx(0.25 + 1e-3 * 500.0 * (demand - 0.01))
    assert np.array_equal(data["plant.velocity"], plain["plant.velocity"])


def test_given_states_that_change_nothing() -> None:
    same = SHORT._replace(start=AsBuilt(nested({"plant.velocity": 0.0})))
    assert np.array_equal(simulate(same)["plant.velocity"], simulate(SHORT)["plant.velocity"])


@pytest.mark.parametrize(
    ("path", "problem"),
    [
        ("plant.speed", "no 'speed' there; the names are velocity, hydraulic_force, position"),
        ("plant", "is not a number of the state"),
    ],
)
def test_a_state_that_there_is_not(path: str, problem: str) -> None:
    with pytest.raises(ParameterError, match=f"start.given.{path}") as caught:
        simulate(SHORT._replace(start=AsBuilt(nested({path: 1.0}))))
    assert problem in str(caught.value)


@pytest.mark.slow  # compiles lanes
def test_runs_of_a_batch_start_as_they_are_given() -> None:
    loop = SHORT._replace(start=AsBuilt(nested({"plant.velocity": 0.0})))
    starts = np.array([0.0, 0.02, -0.01])
    table = simulate_batch(loop, {"start.given.plant.velocity": starts}, strict=True)
    for run, start in enumerate(starts):
        alone = simulate(replace(loop, {"start.given.plant.velocity": start}), strict=True)
        assert float(table["max_error"][run]) == float(alone["max_error"])


def test_a_scenario_gives_states_in_their_units(tmp_path: Path) -> None:
    file = tmp_path / "given.toml"
    file.write_text(
        'base = "rig/excavator-link-pi"\nstart.given.plant.velocity = "10 mm/s"\n', encoding="utf-8"
    )
    loop = load_scenario(file)
    assert loop.start == AsBuilt(nested({"plant.velocity": 0.01}))
    assert field_at(loop, "start.given.plant.velocity").unit == "m/s"
    for text, problem in {
        'start.given.plant.velocity = "10 mm"': "'10 mm' does not convert to m/s",
        "start.given.plant.speed = 1": "unknown key",
        'start = "fast"': "'fast' must be \"steady\", or a table",
        'start.type = "Steady"\nstart.force = 1': "unknown key",
    }.items():
        file.write_text(f'base = "rig/excavator-link-pi"\n{text}\n', encoding="utf-8")
        with pytest.raises(ScenarioError) as caught:
            load_scenario(file)
        assert problem in str(caught.value)
        assert "\n" not in str(caught.value)


def test_steady_is_a_word_of_a_scenario(tmp_path: Path) -> None:
    file = tmp_path / "steady.toml"
    file.write_text('start = "steady"\nbase = "rig/excavator-link-pi"\n', encoding="utf-8")
    assert load_scenario(file).start == Steady()
    assert load_scenario(file, {"start.command": "0.5 V"}).start == Steady(0.5)


@pytest.mark.parametrize("command", [0.0, 0.05, -0.2])
@pytest.mark.parametrize("force", [0.0, 300.0])
def test_a_symmetric_axis_settles_where_its_flow_balance_says(command: float, force: float) -> None:
    """A v + C p_L = K_q x_v sqrt((p_s - sgn p_L)/rho) with A p_L = b v + F."""
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(force))
    loop, found = settled(loop, command)
    plant, valve, drop = loop.plant, loop.valve, loop.supply.supply_pressure
    v, pressure = found.plant.velocity, found.plant.hydraulic_force / plant.piston_area
    assert found.plant.hydraulic_force == pytest.approx(plant.damping * v + force, rel=1e-9, abs=1e-9)
    opening = valve.gain * command
    assert found.valve.opening == pytest.approx(opening, rel=1e-12, abs=1e-18)
    passed = plant.piston_area * v + plant.leakage * pressure
    sign = math.copysign(1.0, opening)
    flow = opening * valve.orifice.conductance() * math.sqrt(drop - sign * pressure)
    assert passed == pytest.approx(flow, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("valve", [StaticValve, SecondOrderValve])
def test_a_cylinder_that_holds_its_load_rests_where_its_leaks_balance(valve: type) -> None:
    """Through edges alike, p_A + p_B is the supply's pressure, and the difference holds the load."""
    body = example(Loop).valve if valve is StaticValve else example(valve)
    loop = example(
        Loop, BRIEF, plant=example(Cylinder), valve=body._replace(orifice=EDGES), load=Constant(100.0)
    )
    loop, found = settled(loop)
    plant = found.plant
    held = loop.plant.area_a * (plant.pressure_a - plant.pressure_b)
    assert held == pytest.approx(100.0 + loop.plant.friction.simplified() * plant.velocity, rel=1e-9)
    assert plant.pressure_a + plant.pressure_b == pytest.approx(loop.supply.supply_pressure, rel=1e-9)
    assert plant.velocity < 0.0  # the load pushes it back through the leaks


def test_a_run_from_the_steady_state_stays_there() -> None:
    loop = replace(load_scenario("rig/excavator-link-pi"), {"start": Steady(), "simulation.duration": 0.02})
    start = runnable_loop(loop).init()
    loop, found = runnable_loop(loop), start.plant
    rates = loop.rates(loop.machine(start), 0.0, loop.load.force(0.0))
    assert abs(rates.plant.velocity) < 1e-9
    assert abs(rates.plant.pressure_a) < 1e-2  # [Pa/s] of 9e6 Pa
    assert found.position == loop.plant.start_position


def test_no_steady_state_is_one_line() -> None:
    """A piston that moves, behind a valve that is shut."""
    moving = Steady(given=nested({"plant.velocity": 0.1}))
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(0.0), start=moving)
    with pytest.raises(ParameterError, match=r"start.*has no steady state under 0 V and 0 N on the rod"):
        simulate(loop)


@pytest.mark.slow  # compiles lanes
def test_each_machine_of_a_batch_settles_by_itself() -> None:
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(0.0), start=Steady(0.1))
    forces = np.array([0.0, 200.0])
    table = simulate_batch(loop, {"load.amplitude": forces}, strict=True)
    for run, force in enumerate(forces):
        alone = simulate(replace(loop, {"load.amplitude": force}), strict=True)
        assert float(table["max_error"][run]) == float(alone["max_error"])
    assert float(table["max_error"][0]) != float(table["max_error"][1])


AXES = {
    "plant.oil.liquid_bulk_modulus": (0.8, 1.2),
    "plant.friction.viscous": (0.5, 1.5),
    "valve.natural_frequency": (0.9, 1.1),
}


def drawn(name: str, runs: int) -> tuple[Loop, dict[str, np.ndarray]]:
    loop, rng = load_scenario(name), np.random.default_rng(1)
    return loop, {path: value_at(loop, path) * rng.uniform(*ends, runs) for path, ends in AXES.items()}


@pytest.mark.parametrize("name", ["axis/position", "axis/crane"])
def test_a_machine_of_many_settles_with_the_bits_that_it_has_alone(name: str) -> None:
    loop, columns = drawn(name, 8)
    asked, _ = prepare_loop(loop)
    found = start_columns(asked, columns)
    for run in range(8):
        alone = runnable_loop(replace(loop, {path: float(row[run]) for path, row in columns.items()}))
        assert {f"start.given.{path}": value for path, value in leaves(alone.start.given)} == {
            path: row[run] for path, row in found.items()
        }
    part = start_columns(asked, {path: row[5:] for path, row in columns.items()})
    assert all(np.array_equal(part[path], row[5:]) for path, row in found.items())


@pytest.mark.parametrize("name", ["axis/position", "axis/force", "axis/crane", "axis/pump-controlled"])
def test_machines_settle_where_minpack_says(name: str) -> None:
    """Its search begun beside the state found comes back to it, with the bristles bent as they were."""
    loop = runnable_loop(load_scenario(name, {"start": "steady"}))
    state = loop.machine(loop.init())
    numbers, force = np.array(values(state)), loop.load.force(0.0)
    sizes = np.array([size for _, size in state_sizes(state)])
    paths = [path for path, _ in leaves(state)]
    free = [i for i, path in enumerate(paths) if not path.startswith(("plant.position", "plant.friction."))]
    watched = [i for i, path in enumerate(paths) if path != "plant.position"]

    def rates(x: np.ndarray) -> np.ndarray:
        moved = numbers.copy()
        moved[free] += sizes[free] * x
        return np.array(values(loop.rates(filled(state, iter(moved.tolist())), 0.0, force)))[watched]

    still = rates(np.zeros(len(free)))
    weights = 1e3 * np.max([np.abs(rates(1e-3 * row) - still) for row in np.eye(len(free))], axis=0)
    assert np.abs(still / weights).max() < 1e-9
    beside = np.full(len(free), 1e-4)
    found = least_squares(
        lambda x: rates(x) / weights, beside, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    assert np.abs(found.x).max() < 1e-7  # of the sizes; an opening of 2 um to 1e-14 m


def test_the_first_run_that_does_not_settle_is_named() -> None:
    """Pistons that move, behind valves that are shut."""
    moving = Steady(given=nested({"plant.velocity": 0.1}))
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(0.0), start=moving)
    columns = {"start.command": np.array([0.0, 0.0])}
    with pytest.raises(ParameterError, match=r"does not settle, in run 3$"):
        start_columns(loop, columns, first=3)


@role(Start)
class HalfWay(NamedTuple):
    """A start between rest and a steady state, and with an integral that holds what is left."""

    command: Annotated[float, Field("V", "command of the steady state")] = 0.1
    given: Block = group({})

    def found(self, steady: Callable[[float], Block]) -> Block:
        velocity = steady(self.command).plant.velocity
        return nested({"plant.velocity": 0.5 * velocity, "controller.integral": 0.5 * self.command})

    def of(self, s: Block) -> Block:
        return s


def test_a_start_of_one_s_own_finds_the_states_that_it_wants() -> None:
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(0.0), start=HalfWay())
    there, found = settled(loop._replace(start=AsBuilt()), 0.1)
    state = runnable_loop(loop).init()
    assert state.plant.velocity == 0.5 * found.plant.velocity > 0.0
    assert state.plant.hydraulic_force == there.init().plant.hydraulic_force
    assert state.controller.integral == 0.05
    data = simulate(loop, metrics=(), compiled=False)
    assert data["plant.velocity"].values[0] == state.plant.velocity
    given = runnable_loop(loop._replace(start=HalfWay(given=nested({"controller.integral": 0.3})))).init()
    assert (given.plant.velocity, given.controller.integral) == (state.plant.velocity, 0.3)


def test_a_start_of_one_s_own_finds_them_for_each_run_of_a_batch() -> None:
    loop = example(Loop, BRIEF, valve=example(FirstOrderValve), load=Constant(0.0), start=HalfWay())
    changes = {"load.amplitude": np.array([0.0, 200.0]), "plant.mass": np.array([6.0, 7.0])}
    table = simulate_batch(loop, changes, strict=True)
    for run in range(2):
        alone = simulate(replace(loop, {path: row[run] for path, row in changes.items()}), strict=True)
        assert float(table["max_error"][run]) == float(alone["max_error"])
    assert float(table["max_error"][0]) != float(table["max_error"][1])


def test_a_start_that_finds_what_there_is_not_is_one_line() -> None:
    class Wrong(NamedTuple):
        given: Block = group({})

        def found(self, steady: Callable[[float], Block]) -> Block:
            return nested({"plant.speed": 0.1})

        def of(self, s: Block) -> Block:
            return s

    with pytest.raises(ParameterError, match=r"start\.given\.plant\.speed.*no 'speed' there"):
        simulate(example(Loop, BRIEF, start=Wrong()))


@pytest.mark.parametrize("scale", [-2.0, 0.0, 1.0])
@pytest.mark.parametrize("name", ["axis/position", "axis/force", "cases/stick-slip"])
def test_a_friction_that_sticks_holds_no_more_than_its_breakaway(name: str, scale: float) -> None:
    loop = runnable_loop(load_scenario(name, {"start": "steady", "uncertainty.scale": scale}))
    friction, state = loop.plant.friction, loop.init().plant.friction
    assert abs(friction.bristle_stiffness * state.deflection) <= friction.breakaway


OIL = {"type": "ConstantOil", "effective_bulk_modulus": "6000 bar"}
PIPE = {"inner_diameter": "12 mm", "kinematic_viscosity": "32 mm^2/s", "oil": OIL}
HOSES = {"type": "Hoses.from_dimensions", "length": "2 m", **PIPE}
LINES = {"type": "Lines.from_dimensions", "length": "30 m", "highest_frequency": "30 Hz", **PIPE}


@pytest.mark.parametrize("drive", [HOSES, LINES], ids=["hoses", "lines"])
@pytest.mark.parametrize("command", [0.0, 0.5, -1.0])
def test_lines_before_a_cylinder_settle_too(drive: dict[str, object], command: float) -> None:
    """Their flows are a millionth of what pressures are."""
    loop = load_scenario("axis/position", {"drive": drive, "start": {"type": "Steady", "command": command}})
    loop = runnable_loop(loop)
    state = loop.init()
    rates = loop.deriv(
        0.0, loop.machine(state), loop.held(loop.sample(state, 0.0, 1e-3)._replace(hold=state.hold))
    )
    assert abs(rates.plant.velocity) < 1e-3
    assert abs(rates.drive.pressure_a) < 1e3
