"""What a loop leaves open is filled from its machine, and means the same in Python and in a scenario."""

from pathlib import Path
from typing import Any, NamedTuple

import pytest

from hydroservo import Loop, ParameterError, ScenarioError, Simulation, replace, simulate
from hydroservo.control.controllers import (
    DAC,
    PI,
    TSMC,
    AntiWindup,
    Backstepping,
    Delay,
    RateLimit,
    Saturation,
)
from hydroservo.control.wiring import believed, wired
from hydroservo.core.block import Block, model_in
from hydroservo.core.hooks import at_rest
from hydroservo.machine.mechanics import Mass
from hydroservo.machine.oils import AeratedOil
from hydroservo.machine.plants import Cylinder, DesignModel, LoadPressurePlant, ThisMachine
from hydroservo.machine.sensors import DelayedSensors, Dropout, Encoder, IdealSensors, RigSensors
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.papers.tsmc_eha_2021.machine import MODEL
from hydroservo.runs.provenance import scenario_hash
from hydroservo.runs.results import metrics_of
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario
from hydroservo.scenario.registry import load_plugin
from hydroservo.testing.examples import example
from tests.support.bases import DATASHEET, on_base
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.usefixtures("forgotten")

PROPORTIONAL = {"controller.type": "PI", "controller.proportional_gain": 3}
SHORT = Simulation(0.02, 1e-3, 20, record_period=1e-3)
CYLINDER = Cylinder.from_diameters(63e-3, 45e-3, 70e-3, AeratedOil(), Mass(6.0))
MACHINE = example(Loop, SHORT, plant=CYLINDER, supply=IdealSupply(160e5))
SCENARIO = DATASHEET + 'mechanism = {type = "Mass", mass = "6 kg"}\n'


def written(folder: Path, text: str, name: str = "my.toml") -> Path:
    path = folder / name
    path.write_text(on_base(text, "tsmc") if path.suffix == ".toml" else text, encoding="utf-8")
    return path


def same_metrics(one: Loop, other: Loop) -> bool:
    found = [metrics_of(simulate(loop, record=[], compiled=False)) for loop in (one, other)]
    assert {"rms_error", "estimate_rms_error_1", "disturbance_rms_2"} < set(found[0])
    return repr(found[0]) == repr(found[1])  # so that nan is itself


# Models


def test_a_law_that_is_told_nothing_believes_in_this_machine() -> None:
    loop = MACHINE._replace(controller=example(TSMC))
    model = wired(loop).controller.model
    assert isinstance(loop.controller.model, ThisMachine)
    assert_same_block(model, believed(loop))
    assert model != MODEL
    assert model.plant == at_rest(loop).simplified()
    assert model.supply.supply_pressure == 160e5
    assert wired(wired(loop)) == wired(loop)


def test_python_and_toml_mean_the_same_loop(tmp_path: Path) -> None:
    here, there = MACHINE._replace(controller=example(TSMC)), load_scenario(written(tmp_path, SCENARIO))
    assert_same_block(there.controller.model, wired(here).controller.model)
    assert wired(here) == there
    assert scenario_hash(runnable_loop(here)) == scenario_hash(runnable_loop(there))
    assert same_metrics(here, there)


def test_a_law_put_into_a_loaded_machine_believes_in_that_machine() -> None:
    scenario = load_scenario("rig/excavator-link")
    loop = replace(scenario, {"controller": example(TSMC)})
    model = runnable_loop(loop).controller.model
    assert_same_block(model, believed(scenario))
    assert model.supply.supply_pressure == scenario.supply.simplified().supply_pressure != 40e5
    law = {"controller": {"type": "Backstepping", "velocity_gain": 100, "force_gain": 100}}
    named = load_scenario("rig/excavator-link", law | {"uncertainty.scale": 0})
    nominal = load_scenario("rig/excavator-link", {"uncertainty.scale": 0})
    assert_same_block(
        runnable_loop(replace(nominal, {"controller": example(TSMC)})).controller.model,
        named.controller.model,
    )


def test_a_model_has_no_numbers_before_it_is_filled_in() -> None:
    loop = example(Loop, SHORT, controller=example(TSMC))
    with pytest.raises(ParameterError, match="the names are none: a ThisMachine has no numbers"):
        replace(loop, {"controller.model.plant.mass": 8.0})
    assert replace(wired(loop), {"controller.model.plant.mass": 8.0}).controller.model.plant.mass == 8.0


def test_a_loaded_law_does_not_know_the_uncertainty(tmp_path: Path) -> None:
    loop = load_scenario(written(tmp_path, SCENARIO + '[uncertainty]\nplant.mechanism.mass = "10 %"'))
    certain = load_scenario(written(tmp_path, SCENARIO))
    assert loop.plant.mechanism.mass == pytest.approx(1.1 * certain.plant.mechanism.mass)
    assert_same_block(wired(loop).controller.model, certain.controller.model)  # what is given stays


@pytest.mark.parametrize("law", ["tsmc", "backstepping"])
def test_a_belief_means_the_same_however_it_is_changed(law: str) -> None:
    short = {"simulation.duration": "20 ms", "simulation.period": "0.1 ms"}
    believing = {"controller.model.plant.mass": 8.0}
    loop = load_scenario(f"paper/sine-{law}", short)
    replaced, given = replace(loop, believing), load_scenario(f"paper/sine-{law}", short | believing)
    assert replaced.controller.model.plant.mass == 8.0
    assert replaced == given
    found = [metrics_of(simulate(one, record=[], compiled=False)) for one in (loop, replaced, given)]
    assert repr(found[1]) == repr(found[2]) != repr(found[0])


def test_disturbances_are_those_besides_the_law_s_own_model() -> None:
    """d_L1 = -F_L/m for a law that knows the machine; one that believes in half the mass sees more."""
    runs = [
        simulate(
            example(
                Loop, SHORT, controller=example(TSMC, model=believed(example(Loop))._replace(plant=plant))
            ),
            compiled=False,
        )
        for plant in (example(LoadPressurePlant), example(LoadPressurePlant, mass=3.0))
    ]
    own, other = (run["disturbance.d1"].values for run in runs)
    assert own == pytest.approx(-runs[0]["load.force"].values / 6.0, abs=1e-9)
    assert abs(other - own).max() > 0.1


@pytest.mark.parametrize(
    "wrap",
    [
        lambda law: law,
        DAC,
        lambda law: DAC(example(RateLimit, Delay(law))),
        lambda law: AntiWindup(law, 100.0, Saturation(5.0)),
    ],
    ids=["alone", "DAC", "three", "AntiWindup"],
)
@pytest.mark.parametrize("law", [example(TSMC), example(Backstepping)], ids=["tsmc", "backstepping"])
def test_models_in_wrappers_are_filled_too(wrap: Any, law: Block) -> None:
    loop = MACHINE._replace(controller=wrap(law))
    filled = wired(loop).controller
    assert_same_block(model_in(filled), believed(loop))
    assert_same_block(filled, wrap(law._replace(model=believed(loop))))
    own = example(DesignModel, valve_gain=1e-4)
    given = MACHINE._replace(controller=wrap(law._replace(model=own)))
    assert wired(given) == given


def test_a_wrapper_s_model_and_that_of_its_law_are_filled_both(tmp_path: Path) -> None:
    plugin = written(
        tmp_path,
        """
from typing import NamedTuple
from hydroservo.core.block import Block
from hydroservo.machine.plants import DesignModel, ThisMachine

class Ahead(NamedTuple):
    controller: Block
    model: DesignModel = ThisMachine()

    def init(self):
        return self.controller.init()

    def step(self, s, y, r, dt):
        return self.controller.step(s, y, r, dt)
""",
        "ahead.py",
    )
    (ahead,) = (found for found in load_plugin(plugin) if found.__name__ == "Ahead")
    filled = wired(MACHINE._replace(controller=ahead(controller=example(TSMC)))).controller
    assert_same_block(filled.model, filled.controller.model)
    assert_same_block(filled.controller.model, believed(MACHINE))


# A machine that a model cannot be made of


class Unknown(NamedTuple):
    """A plant that says of itself no more than a run needs."""

    plant: LoadPressurePlant = example(LoadPressurePlant)
    stroke: float = 0.078

    def init(self) -> Block:
        return self.plant.init()

    def flows(self, s: Block, ports: Block) -> Block:
        return self.plant.flows(s, ports)

    def deriv(self, s: Block, flows: Block, force: float) -> Block:
        return self.plant.deriv(s, flows, force)

    def hydraulic_force(self, s: Block) -> float:
        return self.plant.hydraulic_force(s)

    def outputs(self, s: Block, line: Block, force: float) -> Block:
        return self.plant.outputs(s, line, force)


class Spool(NamedTuple):
    """A valve that has another name for its gain."""

    valve: FirstOrderValve = example(FirstOrderValve)

    @property
    def orifice(self) -> Block:
        return self.valve.orifice

    def init(self) -> Block:
        return self.valve.init()

    def deriv(self, s: Block, u: float) -> Block:
        return self.valve.deriv(s, u)

    def opening(self, s: Block, u: float) -> float:
        return self.valve.opening(s, u)


ASIDE = [
    ({"plant": Unknown()}, "plant = 'Unknown': must have a method simplified()"),
    ({"valve": Spool()}, "valve = 'Spool': must have a field gain (a float) and a field orifice"),
]


@pytest.mark.parametrize(("machine", "_says"), ASIDE, ids=["plant", "valve"])
def test_a_law_without_a_model_needs_none_of_its_machine(machine: dict[str, Block], _says: str) -> None:
    loop = example(Loop, SHORT, controller=PI(0.3, 100.0))
    known, unknown = (simulate(one, compiled=False) for one in (loop, loop._replace(**machine)))
    assert metrics_of(known)["rms_error"] == metrics_of(unknown)["rms_error"] or "valve" in machine
    assert not unknown["diverged"]
    assert_same_block(wired(loop._replace(**machine)).controller, loop.controller)


@pytest.mark.parametrize(("machine", "says"), ASIDE, ids=["plant", "valve"])
def test_a_law_that_needs_a_model_is_told_what_is_in_its_way(machine: dict[str, Block], says: str) -> None:
    loop = example(Loop, SHORT, controller=DAC(example(TSMC)))._replace(**machine)
    with pytest.raises(ParameterError) as caught:
        simulate(loop, compiled=False)
    assert str(caught.value).startswith(says)
    assert str(caught.value).endswith("else give the controller a model")
    assert "\n" not in str(caught.value)
    given = replace(loop, {"controller.controller.model": example(DesignModel)})
    assert not simulate(given, compiled=False)["diverged"]


def test_in_a_scenario_it_is_one_line_with_file_and_table(tmp_path: Path) -> None:
    plugin = written(
        tmp_path,
        """
from typing import NamedTuple
from hydroservo.machine.valves import Orifice, StaticValve

class Unmetered(NamedTuple):
    valve: StaticValve = StaticValve(5e-4, 5e-3, Orifice(0.62, 0.024, 850.0))

    @property
    def orifice(self):
        return self.valve.orifice

    def init(self):
        return self.valve.init()

    def deriv(self, s, u):
        return self.valve.deriv(s, u)

    def opening(self, s, u):
        return self.valve.opening(s, u)
""",
        "unmetered.py",
    )
    path = written(tmp_path, 'valve.type = "Unmetered"')
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, plugins=[plugin])
    said = str(caught.value)
    assert said.startswith(f"{path}: valve: Unmetered must have a field gain (a float)")
    assert "\n" not in said
    assert_same_block(load_scenario(path, PROPORTIONAL, [plugin]).controller, PI(3.0))


# Areas


def test_sensors_know_the_areas_of_the_plant() -> None:
    loop = wired(MACHINE._replace(sensors=example(RigSensors)))
    assert (loop.sensors.area_a, loop.sensors.area_b) == (CYLINDER.area_a, CYLINDER.area_b)
    loop = wired(example(Loop, sensors=example(RigSensors)))
    assert loop.sensors.area_a == loop.sensors.area_b == example(LoadPressurePlant).piston_area
    loop = wired(MACHINE._replace(sensors=example(RigSensors, area_a=1e-3)))
    assert (loop.sensors.area_a, loop.sensors.area_b) == (1e-3, CYLINDER.area_b)


def test_sensors_around_others_know_them_too() -> None:
    loop = wired(MACHINE._replace(sensors=DelayedSensors(Dropout(sensors=example(RigSensors)))))
    assert loop.sensors.sensors.sensors.area_b == CYLINDER.area_b
    assert_same_block(wired(MACHINE).sensors, IdealSensors())


def test_python_and_toml_mean_the_same_areas(tmp_path: Path) -> None:
    text = SCENARIO + '[sensors]\ntype = "RigSensors"\nposition = {type = "Encoder", resolution = "1 um"}\n'
    there = load_scenario(written(tmp_path, text))
    here = MACHINE._replace(controller=example(TSMC), sensors=RigSensors(Encoder(1e-6)))
    assert wired(here) == there
    assert (there.sensors.area_a, there.sensors.area_b) == (CYLINDER.area_a, CYLINDER.area_b)
    auto = load_scenario(written(tmp_path, text + 'area_a = "auto"\narea_b = "9 cm^2"'))
    assert (auto.sensors.area_a, auto.sensors.area_b) == (CYLINDER.area_a, pytest.approx(9e-4))


def test_a_plant_that_has_no_area_needs_sensors_that_know_theirs() -> None:
    loop = example(
        Loop, SHORT, plant=Unknown(), controller=PI(0.3, 100.0), sensors=DelayedSensors(example(RigSensors))
    )
    with pytest.raises(ParameterError) as caught:
        simulate(loop, compiled=False)
    assert str(caught.value) == (
        "sensors.sensors.area_a = 'auto': must be given: the plant Unknown has no area_a, nor a piston_area"
    )
    areas = {"sensors.sensors.area_a": 5e-4, "sensors.sensors.area_b": 5e-4}
    assert wired(replace(loop, areas)).sensors.sensors.area_a == 5e-4
