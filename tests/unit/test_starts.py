"""Where runs start: states that are given, and machines that have settled."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest

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
from hydroservo.block import Block, field_at
from hydroservo.group import group, nested
from hydroservo.loads import Constant
from hydroservo.plants import Cylinder
from hydroservo.roles import Start, role
from hydroservo.runs.run import ready
from hydroservo.runs.steady import steady_state
from hydroservo.starts import AsBuilt, Steady
from hydroservo.testing.examples import example
from hydroservo.valves import FirstOrderValve, FourEdges, SecondOrderValve, StaticValve
from tests.support.monitors import SHORT

BRIEF = Simulation(duration=5e-3, period=1e-3, substeps=2, record_period=1e-3)
EDGES = example(FourEdges, clearance=2e-6)


def settled(loop: Loop, command: float = 0.0) -> tuple[Loop, object]:
    loop = ready(loop)
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
        ("plant.speed", "no 'speed' there; the names are velocity, load_force, position"),
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
    v, pressure = found.plant.velocity, found.plant.load_force / plant.piston_area
    assert found.plant.load_force == pytest.approx(plant.damping * v + force, rel=1e-9, abs=1e-9)
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
    start = ready(loop).init()
    loop, found = ready(loop), start.plant
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
    state = ready(loop).init()
    assert state.plant.velocity == 0.5 * found.plant.velocity > 0.0
    assert state.plant.load_force == there.init().plant.load_force
    assert state.controller.integral == 0.05
    data = simulate(loop, metrics=(), compiled=False)
    assert data["plant.velocity"].values[0] == state.plant.velocity
    given = ready(loop._replace(start=HalfWay(given=nested({"controller.integral": 0.3})))).init()
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
    loop = ready(load_scenario(name, {"start": "steady", "uncertainty.scale": scale}))
    friction, state = loop.plant.friction, loop.init().plant.friction
    assert abs(friction.bristle_stiffness * state.deflection) <= friction.breakaway
