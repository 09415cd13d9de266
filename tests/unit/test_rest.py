"""Machines stand still at their start where it is left open."""

import math
from pathlib import Path

import numpy as np
import pytest

from hydroservo import Loop, ParameterError, ScenarioError, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.references import Step as StepReference
from hydroservo.control.wiring import believed
from hydroservo.core.block import Block
from hydroservo.core.hooks import at_rest
from hydroservo.core.signals import Pressures
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.machine.loads import Constant, Sine, Step
from hydroservo.machine.mechanics import LuGre, Mass, MassSpringDamper, OneLinkArm
from hydroservo.machine.oils import AeratedOil, ConstantOil
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.starts import Steady
from hydroservo.machine.supplies import IdealSupply, PumpSupply, ReliefValve
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.columns import start_columns
from hydroservo.runs.objective import is_possible
from hydroservo.runs.provenance import scenario_hash
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from hydroservo.scenario.parameter_draws import draws
from hydroservo.testing.examples import example
from tests.support.bases import DATASHEET, on_base

LINE = Pressures(160e5, 2e5)
AT_REST = 1e-12  # m/s: what the rounding of pressures of 1e7 Pa does to some kg
PUMP = example(PumpSupply, relief=example(ReliefValve, 160e5), max_torque=20.0)


def cylinder(**changes: Block) -> Cylinder:
    """A 63/45 mm cylinder from its catalogue."""
    parts = {"oil": ConstantOil(1.2e9), "mechanism": Mass(100.0)} | changes
    return Cylinder.from_diameters(0.063, 0.045, 0.07, **parts)


def shut(plant: Cylinder, **changes: Block) -> Loop:
    """A loop whose valve stays shut: nothing is demanded of a piston at rest."""
    parts = {"supply": IdealSupply(160e5), "load": Constant(0.0)} | changes
    return example(
        Loop,
        Simulation(0.01, 1e-3, 100, 1e-3),
        plant,
        reference=StepReference(0.0, 0.0),
        controller=example(PI, 1.0),
        **parts,
    )


CONSTANT, AERATED = ConstantOil(1.2e9), AeratedOil()
SPRING = example(MassSpringDamper, 100.0, rest_position=0.01)


@pytest.mark.parametrize(
    ("oil", "mechanism", "supply", "load"),
    [
        (CONSTANT, Mass(100.0), IdealSupply(160e5), Constant(0.0)),
        (AERATED, Mass(100.0), IdealSupply(160e5, 2e5), Constant(6000.0)),
        (CONSTANT, example(OneLinkArm), IdealSupply(160e5), Constant(-6000.0)),
        (AERATED, example(OneLinkArm), PUMP, Sine(1000.0, phase=1.0, frequency=0.0)),
        (CONSTANT, SPRING, PUMP, example(Step, 500.0, time=1.0)),
        (AERATED, SPRING, IdealSupply(160e5, 2e5), Constant(0.0)),
    ],
)
def test_a_cylinder_from_its_datasheet_stands_still(
    oil: Block, mechanism: Block, supply: Block, load: Block
) -> None:
    loop = shut(cylinder(oil=oil, mechanism=mechanism), supply=supply, load=load)
    run = simulate(loop, compiled=False)
    assert abs(run["plant.velocity"]).max() < AT_REST
    assert abs(run["plant.position"] - 0.035).max() < AT_REST


def test_half_the_paper_s_supply_made_it_jump() -> None:
    """What the defaults were: 3.2 kN on a shut valve."""
    plant = cylinder()._replace(start_pressure_a=20e5, start_pressure_b=20e5)
    assert plant.hydraulic_force(plant.init()) == pytest.approx(math.pi / 4 * 0.045**2 * 20e5)
    assert abs(simulate(shut(plant), compiled=False)["plant.velocity"]).max() > 0.01


def test_the_pressures_are_those_that_a_matched_valve_holds() -> None:
    """The force is balanced, and p_A + p_B = p_s + p_r."""
    plant = cylinder().at_rest(LINE, 5000.0)
    assert plant.hydraulic_force(plant.init()) == pytest.approx(5000.0, rel=1e-13)
    assert plant.start_pressure_a + plant.start_pressure_b == pytest.approx(162e5, rel=1e-15)


def test_a_symmetric_cylinder_starts_at_half_the_supply_to_the_bit() -> None:
    plant = example(Cylinder).at_rest(Pressures(40e5, 0.0), 0.0)
    assert (plant.start_pressure_a, plant.start_pressure_b) == (20e5, 20e5)


def test_one_pressure_may_be_given() -> None:
    given = cylinder()._replace(start_pressure_b=90e5)
    plant = given.at_rest(LINE, 5000.0)
    assert plant.start_pressure_b == 90e5
    assert plant.hydraulic_force(plant.init()) == pytest.approx(5000.0, rel=1e-13)
    other = cylinder()._replace(start_pressure_a=plant.start_pressure_a).at_rest(LINE, 5000.0)
    assert other.start_pressure_b == pytest.approx(90e5, rel=1e-13)


def test_what_is_given_stays() -> None:
    given = cylinder()._replace(start_pressure_a=1e5, start_pressure_b=2e5)
    assert given.at_rest(LINE, 1e9) is given
    paper = example(LoadPressurePlant)
    assert at_rest(example(Loop, plant=paper)) is paper


def test_the_start_of_a_datasheet_s_cylinder_can_be_given() -> None:
    plant = Cylinder.from_diameters(
        0.063,
        0.045,
        0.5,
        CONSTANT,
        Mass(100.0),
        start_position=0.1,
        start_pressure_a=3e5,
        start_pressure_b=5e5,
    )
    assert plant.init()[:4] == (0.0, 0.1, 3e5, 5e5)
    assert Cylinder.from_diameters(0.063, 0.045, 0.5, CONSTANT, Mass(100.0)).start_position == 0.25


def test_a_load_that_nothing_holds_is_one_line() -> None:
    with pytest.raises(ParameterError) as error:
        simulate(shut(cylinder(), load=Constant(60e3)))
    assert str(error.value) == (
        "plant.start_pressure_a = 'auto': rest under 6e+04 [N] needs 1.818e+07 [Pa], and between tank and "
        "supply are 0 to 1.6e+07; lower the load or give start pressures"
    )


def test_a_design_model_needs_the_start() -> None:
    with pytest.raises(ParameterError, match=r"start_pressure_a = 'auto': must be found first"):
        cylinder(oil=AeratedOil()).simplified()
    mean = 81e5
    plant = cylinder(oil=AeratedOil()).at_rest(LINE, 5000.0)
    assert plant.simplified().bulk_modulus == pytest.approx(AeratedOil().bulk_modulus(mean), rel=1e-12)


SCENARIO = f"""{DATASHEET}
start_pressure_b = "auto"
[plant.mechanism]
type = "OneLinkArm"
base_distance = "300 mm"
pin_distance = "80 mm"
closed_length = "271.5 mm"
level_angle = "90 deg"
arm_inertia = "0.25 kg m^2"
arm_mass = "2 kg"
centre_distance = "300 mm"
moving_mass = "1 kg"
payload = "3 kg"
reach = "600 mm"
[load]
type = "Constant"
amplitude = "1 kN"
[reference]
type = "Step"
initial = "0 m/s"
final = "0 m/s"
[controller]
type = "PI"
proportional_gain = "0.1 V s/m"
[uncertainty]
plant.mechanism.payload = "50 %"
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "link.toml"
    file.write_text(on_base(SCENARIO), encoding="utf-8")
    return file


def test_a_scenario_starts_at_rest(scenario: Path) -> None:
    """With its uncertainty, which a model of the machine does not know of."""
    loop, certain = load_scenario(scenario), load_scenario(scenario, {"uncertainty.scale": 0})
    run = simulate(loop, compiled=False)
    assert abs(run["plant.velocity"]).max() < AT_REST
    assert believed(certain).plant.bulk_modulus == pytest.approx(AeratedOil().bulk_modulus(80e5))
    assert "start_pressure_a = inf" not in run.attrs["scenario"]


def test_numbers_of_a_scenario_s_start(scenario: Path) -> None:
    changes = {"plant.start_position": "10 mm", "plant.start_pressure_a": "30 bar"}
    plant = load_scenario(scenario, changes).plant
    assert (plant.start_position, plant.start_pressure_a) == (0.01, 30e5)
    assert load_scenario(scenario, {"plant.start_position": "auto"}).plant.start_position == 0.035


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"load.amplitude": "60 kN"}, "plant.start_pressure_a = 'auto': rest under"),
        ({"plant.start_pressure_a": "half"}, 'must be a finite number above -101325 [Pa] or "auto"'),
        ({"plant.start_pressure_a": "-2 bar"}, 'must be a finite number above -101325 [Pa] or "auto"'),
        ({"uncertainty.plant.start_pressure_a": 0.1}, 'deviates from plant.start_pressure_a = "auto"'),
        (
            {"load.amplitude": "40 kN", "uncertainty.load.amplitude": 0.5},
            "uncertainty: leads to plant.start_pr",
        ),
    ],
)
def test_what_a_scenario_s_start_may_not_be(scenario: Path, changes: dict[str, object], says: str) -> None:
    with pytest.raises(ScenarioError) as error:
        load_scenario(scenario, changes)
    assert says in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow  # some ten seconds
def test_each_run_of_a_batch_starts_at_its_own_rest(scenario: Path) -> None:
    """And has the bits of the single run."""
    loop = load_scenario(scenario)
    columns = {
        "plant.area_b": np.linspace(10e-4, 25e-4, 5),
        "plant.mechanism.payload": np.linspace(0.0, 20.0, 5),
        "load.amplitude": np.linspace(-2000.0, 2000.0, 5),
        "supply.supply_pressure": np.linspace(150e5, 250e5, 5),
    }
    table = simulate_batch(loop, columns, strict=True)
    assert table["max_error"].max() < AT_REST
    for i in range(5):
        own = replace(loop, {path: float(values[i]) for path, values in columns.items()})
        assert simulate(own, strict=True)["max_error"] == table["max_error"][i]


def test_runs_whose_machine_is_the_same_share_its_start(scenario: Path) -> None:
    assert (
        start_columns(load_scenario(scenario), {"controller.proportional_gain": np.array([1.0, 2.0])}) == {}
    )


def test_a_run_of_a_batch_that_cannot_rest_is_named(scenario: Path) -> None:
    with pytest.raises(ParameterError, match=r"plant\.start_pressure_a = 'auto': rest under .*, in run 1$"):
        simulate_batch(load_scenario(scenario), {"load.amplitude": [1e3, 60e3]})


def test_the_other_pressure_follows_where_one_varies(scenario: Path) -> None:
    loop = load_scenario(scenario)
    given = np.array([40e5, 60e5, 80e5])
    found = start_columns(loop, {"plant.start_pressure_b": given})
    assert [*found] == ["plant.start_pressure_a"]
    force = loop.load.amplitude + loop.plant.mechanism.resistance(0.035, 0.0)
    balance = loop.plant.area_a * found["plant.start_pressure_a"] - loop.plant.area_b * given
    assert balance == pytest.approx(force)


def test_a_search_passes_over_machines_that_cannot_be(scenario: Path) -> None:
    loads = {"load.amplitude": np.array([1e3, 60e3])}
    lengths = {"plant.start_position": np.array([0.01, 0.08])}
    for candidates in (loads, lengths):
        assert [is_possible(load_scenario(scenario), candidates, k) for k in (0, 1)] == [True, False]


def test_the_hash_tells_starts_apart(scenario: Path) -> None:
    hashes = {
        scenario_hash(load_scenario(scenario, changes))
        for changes in ({}, {"plant.start_pressure_a": "30 bar"}, {"plant.start_pressure_a": "31 bar"})
    }
    assert len(hashes) == 3


def test_friction_with_memory_rests_too() -> None:
    run = simulate(shut(cylinder(friction=example(LuGre), mechanism=example(OneLinkArm))), compiled=False)
    assert abs(run["plant.velocity"]).max() < AT_REST


def test_an_export_holds_the_numbers_that_were_found(scenario: Path) -> None:
    loop = load_scenario(scenario)
    found = at_rest(loop)
    unit = exported_unit(loop, Part.MACHINE, prefix="machine", title="a link")
    parameters = {one.path: one.value for one in unit.parameters}
    assert parameters["plant.start_pressure_a"] == found.start_pressure_a
    assert parameters["plant.start_pressure_b"] == found.start_pressure_b


def test_ranges_of_a_start_that_is_open(scenario: Path) -> None:
    loop, path = load_scenario(scenario), "plant.start_pressure_a"
    assert draws(loop, {path: "30..40 bar"}, 1).ranges == {path: (30e5, 40e5)}
    with pytest.raises(ScenarioError, match='is "auto" in the scenario, so no percentage of it can be taken'):
        draws(loop, {path: "-10%..10%"}, 1)


def test_no_run_of_a_batch_starts_at_a_pressure_that_is_none() -> None:
    loop = example(Loop, Simulation(0.01, 1e-3, 20), plant=example(Cylinder), controller=example(PI))
    with pytest.raises(ParameterError, match="start_pressure_a = inf: must be a finite number"):
        simulate_batch(loop, {"plant.start_pressure_a": np.array([math.inf, 20e5])})


def test_a_load_beyond_the_supply_blames_no_uncertainty_where_there_is_none() -> None:
    axis = Path(__file__).parents[2] / "examples" / "axis.toml"
    with pytest.raises(ScenarioError) as error:
        load_scenario(axis, {"load": {"type": "Constant", "amplitude": "1e6 N"}})
    assert f"{axis}, overridden: plant.start_pressure_a = 'auto': rest under 1e+06 [N] needs" in str(
        error.value
    )


@pytest.mark.parametrize(
    ("command", "pressures", "velocity"),
    [(0.0, (0.9731333e5, 97.250907e5), 8.237791e-4), (-1.0, (6.746932e5, 114.840730e5), -5.042064e-3)],
)
def test_a_rest_is_above_vacuum(command: float, pressures: tuple[float, float], velocity: float) -> None:
    """A rod pulled with 15 kN, which the tank's pressure in one chamber does not hold unless it moves."""
    given = {"plant.start_pressure_a": 40e5, "plant.start_pressure_b": 85e5}
    loop = replace(
        load_scenario("axis/position"),
        {**given, "load": Constant(-15e3), "start": Steady(command=command)},
    )
    state = runnable_loop(loop).init().plant
    assert (state.pressure_a, state.pressure_b) == pytest.approx(pressures, rel=1e-5)
    assert state.velocity == pytest.approx(velocity, rel=1e-4)
