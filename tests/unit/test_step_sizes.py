"""How fast a machine moves, whether steps follow it, and how many it takes."""

import cmath
import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, ScenarioError, Simulation, ops, replace, simulate, simulate_batch
from hydroservo.control.controllers import PI
from hydroservo.control.loop import AUTO
from hydroservo.control.references import Square as SquareDemand
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.validation import checked
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.machine.loads import Constant, Square
from hydroservo.machine.plants import LoadPressurePlant
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.runs.columns import hardest_loop
from hydroservo.runs.step_sizes import (
    checked_steps,
    coarseness,
    fastest_rate,
    fastest_rates,
    largest_difference,
    machine_paths,
    settle_substeps,
)
from hydroservo.scenario import load_scenario, parse_override
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block
from tests.support.scenarios import MACHINES
from tests.support.tiers import mostly

EXAMPLES = Path(__file__).parents[2] / "examples"
SHORT = Simulation(duration=0.5, period=1e-3, record_period=1e-3)
LOOP = example(Loop, simulation=SHORT, controller=PI(0.3, 100.0))
STIFF = replace(LOOP, {"plant.bulk_modulus": 7e10, "controller.proportional_gain": 0.03})
SOFT = replace(LOOP, {"plant.bulk_modulus": 7e6, "plant.damping": 2000.0, "controller": PI(0.03, 1.0)})
UNALIGNED = LOOP._replace(load=Square(100.0, 0.0837))
STEPPED = LOOP._replace(
    reference=example(SquareDemand), controller=PI(3.0, 600.0), valve=example(FirstOrderValve)
)


def with_substeps(loop: Loop, substeps: int) -> Loop:
    changed: Loop = replace(loop, {"simulation.substeps": substeps})
    return changed


def recorded(log: list[int]) -> Callable[[Loop], xr.Dataset]:
    """Simulates, and writes down with how many substeps."""

    def run(loop: Loop) -> xr.Dataset:
        log.append(loop.simulation.substeps)
        return simulate(loop)

    return run


def natural_rate(plant: LoadPressurePlant) -> float:
    """The larger |lambda| of the cylinder with its valve shut, from its matrix's trace and determinant."""
    stiffness = 4.0 * plant.bulk_modulus / plant.total_volume
    half_trace = -0.5 * (plant.damping / plant.mass + stiffness * plant.leakage)
    determinant = stiffness * (plant.leakage * plant.damping + plant.piston_area**2) / plant.mass
    root = cmath.sqrt(half_trace**2 - determinant)
    return max(abs(half_trace + root), abs(half_trace - root))


@pytest.mark.parametrize("bulk_modulus", [7e6, 7e8, 7e10])
def test_at_the_start_the_fastest_rate_is_that_of_the_shut_cylinder(bulk_modulus: float) -> None:
    """An underdamped pair, whose size is the hydraulic natural frequency, or with stiff oil the leakage's."""
    loop = replace(LOOP, {"plant.bulk_modulus": bulk_modulus})
    assert fastest_rate(loop) == pytest.approx(natural_rate(loop.plant), rel=1e-6)


def test_a_fast_valve_is_the_fastest() -> None:
    valve = example(FirstOrderValve, time_constant=1e-5)
    assert fastest_rate(LOOP._replace(valve=valve)) == pytest.approx(1e5, rel=1e-6)


def test_along_a_run_the_rates_are_near_that_of_the_start() -> None:
    found = fastest_rates(LOOP, simulate(with_substeps(LOOP, 10)))
    assert found.size >= 8
    assert found == pytest.approx(fastest_rate(LOOP), rel=0.05)


def test_an_orifice_near_a_vanishing_drop_shows() -> None:
    """Held shut against nearly the supply pressure, it is as steep as one over the root of the drop."""
    loop = LOOP._replace(load=Constant(1960.0))
    data = simulate(with_substeps(loop, 50))
    assert fastest_rate(loop, data) > 2.0 * fastest_rate(loop)


def test_only_what_is_finite_counts() -> None:
    data = simulate(with_substeps(LOOP, 10))
    lost = data.copy(deep=True)
    for path in machine_paths(LOOP):
        lost[path].values[250:] = np.nan
    assert fastest_rate(LOOP, lost) == pytest.approx(fastest_rate(LOOP), rel=0.05)
    for path in machine_paths(LOOP):
        lost[path].values[:] = np.nan
    assert fastest_rate(LOOP, lost) == 0.0


@pytest.mark.filterwarnings("ignore:nothing is asked for")  # in so short a run
@pytest.mark.slow  # each compiles a loop
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, MACHINES, ["axis/position", "paper/sine-tsmc"]))
def test_built_in_scenarios_are_trusted(name: str) -> None:
    loop = load_scenario(name, {"simulation.duration": "0.1 s"})
    data = simulate(loop)
    assert coarseness(loop, data) == ""
    assert coarseness(loop) == ""


@pytest.mark.parametrize("loop", [STEPPED, STIFF], ids=["demand that jumps", "stiff oil"])
def test_steps_that_are_too_coarse_say_so(loop: Loop) -> None:
    data = checked_steps(loop, simulate)
    said = data.attrs["warning"]
    assert said == coarseness(loop, simulate(loop))
    assert "\n" not in said
    assert 'RK4 with 1 substep in 0.001 s follows up to 500 1/s; simulation.substeps = "auto" finds' in said
    assert coarseness(loop) != ""


def test_the_warning_goes_where_the_steps_are_short_enough() -> None:
    """At h |lambda| = 0.5, for the fastest motion along the run."""
    data = simulate(with_substeps(LOOP, 10))
    needed = math.ceil(2e-3 * fastest_rate(LOOP, data))
    assert coarseness(with_substeps(LOOP, needed), data) == ""
    assert coarseness(with_substeps(LOOP, needed - 1), data) != ""
    assert "warning" not in checked_steps(with_substeps(LOOP, needed), simulate).attrs


def test_tsit5_is_trusted_until_its_shortest_step_is_too_long() -> None:
    adaptive = replace(STIFF, {"simulation.integrator": Tsit5()})
    assert coarseness(adaptive, simulate(adaptive)) == ""
    assert "shorten simulation.period" in coarseness(
        replace(adaptive, {"simulation.integrator.most_steps": 100})
    )


def test_a_false_alarm_is_not_raised_where_steps_are_within_tolerance() -> None:
    """On a demand that jumps, what is trusted is right to a part in a thousand, and what is not is not."""
    finest = simulate(with_substeps(STEPPED, 200))
    errors = {n: largest_difference(STEPPED, simulate(with_substeps(STEPPED, n)), finest) for n in (1, 3)}
    assert coarseness(with_substeps(STEPPED, 1)) != ""
    assert coarseness(with_substeps(STEPPED, 3)) == ""
    assert errors[3] < 1e-3
    assert errors[1] > 1e-2


def test_a_fast_motion_that_no_run_excites_raises_no_alarm() -> None:
    finest = simulate(with_substeps(LOOP, 200))
    data = checked_steps(LOOP, simulate)
    assert coarseness(LOOP, data) != ""
    assert "warning" not in data.attrs
    assert largest_difference(LOOP, data, finest) < 1e-3
    few = replace(LOOP, {"simulation.integrator": Tsit5(1e-8, 1)})
    assert coarseness(few) != ""
    assert "warning" not in checked_steps(few, simulate).attrs


@pytest.mark.parametrize(("period", "says"), [(0.0837, "first at 0.04185 s; Tsit5"), (0.084, "")])
def test_a_load_that_jumps_inside_a_step_is_looked_at(period: float, says: str) -> None:
    loop = with_substeps(LOOP._replace(load=Square(2000.0, period)), 10)
    log: list[int] = []
    assert says in checked_steps(loop, recorded(log)).attrs.get("warning", "")
    assert log == ([10, 20] if says else [10])
    adaptive = replace(loop, {"simulation.integrator": Tsit5()})
    assert "warning" not in checked_steps(adaptive, simulate).attrs


def test_differences_are_relative_to_each_states_largest_value() -> None:
    a = simulate(with_substeps(LOOP, 10))
    b = a.copy(deep=True)
    assert largest_difference(LOOP, a, b) == 0.0
    b["plant.hydraulic_force"].values[100] += 1e-3 * np.abs(a["plant.hydraulic_force"].values).max()
    assert largest_difference(LOOP, a, b) == pytest.approx(1e-3, rel=1e-2)
    b["plant.velocity"].values[-1] = math.nan
    assert largest_difference(LOOP, a, b) == math.inf
    a["plant.velocity"].values[-1] = math.nan
    assert largest_difference(LOOP, a, b) == pytest.approx(1e-3, rel=1e-2)


def test_a_machine_that_stands_still_settles_at_once() -> None:
    """Its velocity is what rounding leaves, and no shorter step makes that smaller."""
    loop = load_scenario(EXAMPLES / "axis.toml", {"reference.amplitude": 0.0, "simulation.duration": 0.5})
    data = simulate(loop)
    assert 0.0 < np.abs(data["plant.velocity"]).max() < 1e-12
    assert "warning" not in data.attrs
    moved = data.copy(deep=True)
    moved["plant.velocity"].values[-1] = 1e-3
    assert largest_difference(loop, moved, data) > 1e3
    data["plant.velocity"].values[:] = 0.0
    assert largest_difference(loop, moved, data) == math.inf


@pytest.mark.parametrize("loop", [LOOP, STIFF, SOFT], ids=["ordinary", "stiff", "soft"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_auto_picks_what_step_doubling_confirms(loop: Loop, tolerance: float) -> None:
    loop = replace(loop, {"simulation.substeps": AUTO, "simulation.tolerance": tolerance})
    data = checked_steps(loop, simulate)
    substeps, error = data.attrs["substeps"], data.attrs["step_error"]
    assert error <= tolerance
    assert "warning" not in data.attrs
    assert coarseness(with_substeps(loop, substeps), data) == ""
    runs = [simulate(with_substeps(loop, n)) for n in (substeps, 2 * substeps, 8 * substeps)]
    assert largest_difference(loop, *runs[:2]) == error
    assert largest_difference(loop, runs[0], runs[2]) < 2.0 * tolerance
    assert all(np.array_equal(data[path], runs[0][path]) for path in machine_paths(loop))


def test_auto_takes_more_for_a_stiffer_machine_and_a_tighter_tolerance() -> None:
    found = [
        settle_substeps(replace(loop, {"simulation.tolerance": tolerance}), simulate).attrs["substeps"]
        for loop, tolerance in ((SOFT, 1e-6), (LOOP, 1e-6), (LOOP, 1e-9), (STIFF, 1e-9))
    ]
    assert found == sorted(set(found))


def test_auto_does_not_repeat_runs() -> None:
    log: list[int] = []
    chosen = settle_substeps(LOOP, recorded(log)).attrs["substeps"]
    assert log[-2:] == [chosen, 2 * chosen]
    assert len(log) == len(set(log)) <= 3


def test_a_load_that_jumps_inside_substeps_does_not_settle_and_tsit5_does() -> None:
    log: list[int] = []
    lost = settle_substeps(UNALIGNED, recorded(log))
    assert lost.attrs["step_error"] > 1e-5
    assert lost.attrs["warning"].startswith(
        f"the steps did not settle: {lost.attrs['substeps']} substeps and"
    )
    assert "; the load jumps inside a step, first at " in lost.attrs["warning"]
    assert lost.attrs["warning"].endswith(" s; Tsit5 ends one there")
    assert lost.attrs["substeps"] in log[:-1]
    found = settle_substeps(replace(UNALIGNED, {"simulation.integrator": Tsit5()}), simulate)
    assert found.attrs["substeps"] == 1
    assert found.attrs["step_error"] < 1e-6
    assert "warning" not in found.attrs


class UserState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Relay(NamedTuple):
    """A law that switches fully at every sample: the explicit sgn at its worst."""

    level: Annotated[float, Field("V", "command", "this test")] = 5.0

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        return UserState(self.level * ops.sign(r.value - y.velocity))


class Thrown(NamedTuple):
    """A positive feedback that has no command any more once the piston is fast."""

    def init(self) -> UserState:
        return UserState(0.0)

    def step(self, s: UserState, y: Measurement, r: Demand, dt: float) -> UserState:
        u = 5.0 * ops.sign(y.velocity - r.value)
        return UserState(ops.where(ops.absolute(y.velocity) > 0.3, math.nan, u))


def test_a_law_that_chatters_does_not_settle_and_says_how_far_it_is() -> None:
    relay = LOOP._replace(controller=Relay(), simulation=SHORT._replace(duration=2.0))
    log: list[int] = []
    data = settle_substeps(relay, recorded(log))
    assert data.attrs["step_error"] > 1e-3
    assert f"differ by {data.attrs['step_error']:.1e} of" in data.attrs["warning"]
    assert len(log) < 8


def test_a_run_that_diverges_is_given_up_soon() -> None:
    """A positive feedback that throws the piston away, whatever the steps, until the law is lost."""
    log: list[int] = []
    data = settle_substeps(LOOP._replace(controller=Thrown()), recorded(log))
    assert bool(data.diverged)
    assert len(log) < 8


@pytest.mark.parametrize(("first_whole", "calls"), [(2, 3), (1000, 4)])
def test_lost_runs_are_given_up_soon_unless_a_finer_one_is_whole(first_whole: int, calls: int) -> None:
    whole = simulate(with_substeps(LOOP, 10))
    log: list[int] = []

    def run(loop: Loop) -> xr.Dataset:
        log.append(loop.simulation.substeps)
        data = whole.copy(deep=True)
        if len(log) < first_whole:
            data["plant.velocity"].values[-len(log) :] = math.nan
        return data

    data = settle_substeps(LOOP, run)
    assert len(log) == calls
    assert (data.attrs["step_error"] == 0.0) == (first_whole == 2)
    assert ("warning" in data.attrs) == (first_whole == 1000)


def test_the_hardest_of_many_machines() -> None:
    parameters = {
        "plant.bulk_modulus": np.array([7e8, 9e9, 8e8, 1e7]),
        "plant.mass": np.array([6.0, 60.0, 0.06, 6.0]),
        "simulation.seed": np.array([1.0, 2.0, 3.0, 4.0]),
    }
    loop = hardest_loop(LOOP, [parameters])
    assert (loop.plant.bulk_modulus, loop.plant.mass) == (8e8, 0.06)
    assert repr(loop.simulation.seed) == "3"


def test_auto_is_a_word_in_a_scenario_and_a_number_in_python() -> None:
    loop = load_scenario("paper/sine-pi", dict([parse_override("simulation.substeps=auto")]))
    assert loop.simulation.substeps == AUTO
    assert checked(loop).simulation.substeps == AUTO
    for wrong in (0, -2, "atuo"):
        with pytest.raises(ScenarioError, match=r'must be a whole number at least 1 .* or "auto"'):
            load_scenario("paper/sine-pi", {"simulation.substeps": wrong})
    with pytest.raises(ParameterError, match='or "auto"'):
        checked(with_substeps(LOOP, 0))
    with pytest.raises(ScenarioError, match="is not a quantity"):
        load_scenario("paper/sine-pi", {"plant.mass": "auto"})


def test_the_integrator_is_a_nested_table() -> None:
    changes: dict[str, Any] = dict(
        map(parse_override, ("simulation.integrator.type=Tsit5", "simulation.integrator.tolerance=1e-9"))
    )
    assert_same_block(load_scenario("paper/sine-pi", changes).simulation.integrator, Tsit5(1e-9))
    assert_same_block(load_scenario("paper/sine-pi").simulation.integrator, RK4())
    with pytest.raises(ScenarioError, match="did you mean Tsit5"):
        load_scenario("paper/sine-pi", {"simulation.integrator.type": "Tsit"})


def test_the_paths_that_steps_are_judged_by() -> None:
    assert machine_paths(LOOP._replace(valve=example(FirstOrderValve))) == (
        "plant.velocity",
        "plant.hydraulic_force",
        "plant.position",
        "valve.opening",
        "controller.u",
    )


@pytest.mark.parametrize(("substeps", "trusted"), [(1, False), (32, True)])
def test_steps_that_no_rate_can_judge_are_halved(substeps: int, trusted: bool) -> None:
    loop = example(
        Loop,
        Simulation(0.05, 1e-3, substeps, integrator=Rosenbrock()),
        valve=example(FirstOrderValve),
        controller=example(PI, 4.0),
    )
    said = simulate(loop, record=[]).attrs.get("warning", "")
    assert ("twice as many differ by" not in said) == trusted
    batch = simulate_batch(loop, {"plant.mass": np.array([5.0, 6.0])})
    assert ("twice as many differ by" not in batch.attrs.get("warning", "")) == trusted
