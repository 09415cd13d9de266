"""Scenarios become the loops they describe."""

import subprocess
import sys
from pathlib import Path

import pytest

from hydroservo import Loop, ParameterError, ScenarioError, Simulation, replace, simulate
from hydroservo.control.controllers import PI, TSMC, Backstepping, Saturation
from hydroservo.control.observers import Implicit, ModelDerivative, TSMObserver
from hydroservo.control.references import Sine as SineReference
from hydroservo.control.references import Square
from hydroservo.control.wiring import believed, wired
from hydroservo.core.block import leaves, model_in, value_at
from hydroservo.machine.loads import Constant
from hydroservo.machine.loads import Sine as SineLoad
from hydroservo.machine.plants import Cylinder, DesignModel
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.scenario import load_scenario, parse_override, scenario_source, scenarios
from hydroservo.testing.examples import example
from tests.support.bases import CYLINDER, on_base
from tests.support.equality import assert_same_block

DELTA = {
    "plant.damping": 0.2,
    "plant.bulk_modulus": 0.1,
    "plant.leakage": 0.3,
    "valve.orifice.discharge_coefficient": 0.1,
    "valve.orifice.area_gradient": 0.1,
    "valve.orifice.density": 0.15,
}
LEAST = {  # what a scenario without base must say
    "plant.type": "LoadPressurePlant",
    "plant.mass": 6.0,
    "plant.damping": 50.0,
    "plant.piston_area": 4.91e-4,
    "plant.total_volume": 8.74e-5,
    "plant.bulk_modulus": 7e8,
    "plant.leakage": 2.5e-11,
    "plant.stroke": 0.078,
    "plant.start_position": 0.039,
    "valve.type": "StaticValve",
    "valve.gain": 5e-4,
    "valve.max_opening": 5e-3,
    "valve.orifice.type": "Orifice",
    "valve.orifice.discharge_coefficient": 0.62,
    "valve.orifice.area_gradient": 0.024,
    "valve.orifice.density": 850.0,
    "supply.type": "IdealSupply",
    "supply.supply_pressure": 4e6,
    "reference.type": "Sine",
    "reference.amplitude": 0.03,
    "reference.frequency": 0.25,
    "controller.type": "PI",
    "controller.proportional_gain": 100.0,
}


@pytest.fixture
def scenario(tmp_path: Path):
    def write(text: str) -> Path:
        path = tmp_path / "my.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("demand", ["sine", "square"])
@pytest.mark.parametrize(
    ("law", "controller"),
    [
        ("pi", example(PI)),
        ("backstepping", example(Backstepping, derivative=ModelDerivative())),
        ("tsmc", example(TSMC)),
    ],
)
def test_builtin_scenarios_say_what_the_paper_s_numbers_are(
    demand: str, law: str, controller: object
) -> None:
    nominal = load_scenario(f"paper/{demand}-{law}", {"uncertainty.scale": 0})
    wanted = wired(example(Loop, controller=controller))
    if demand == "square":
        wanted = wanted._replace(reference=example(Square), load=example(Constant))
    assert_same_block(nominal, wanted)


@pytest.mark.parametrize("scale", [1, -1, 0.5])
def test_uncertainty_is_the_machine_s_alone(scale: float) -> None:
    loop = load_scenario("paper/sine-tsmc", {"uncertainty.scale": scale})
    for path, relative in DELTA.items():
        assert value_at(loop, path) == value_at(example(Loop), path) * (1.0 + scale * relative)
    assert replace(loop, {path: value_at(example(Loop), path) for path in DELTA}) == wired(
        example(Loop, controller=example(TSMC))
    )


def test_builtin_names_and_text() -> None:
    names = scenarios()
    loops = ("1khz", "10khz", "noisy-1khz", "noisy-10khz", "encoder")
    axes = (
        "crane",
        "force",
        "position",
        "position-adrc",
        "position-adrc-2",
        "position-lq",
        *("press", "press-impedance", "press-override"),
        "pump-controlled",
    )
    laws = {name.rpartition("-")[0] for name in names if name.startswith("laws/")}
    assert {"laws/pi", "laws/linear", "laws/super-twisting", "laws/adrc-1"} <= laws
    assert set(names) == {
        *(f"{law}-{d}" for law in laws for d in ("sine", "square")),
        *(f"axis/{one}" for one in axes),
        *(f"cases/{one}" for one in ("dead-band", "drift", "encoder", "limits", "load-step")),
        *(f"cases/{one}" for one in ("soft-axis", "stick-slip")),
        *(f"paper/{d}-{c}" for d in ("sine", "square") for c in ("pi", "backstepping", "tsmc")),
        *(f"rig/{loop}-{c}-{d}" for loop in loops for c in ("pi", "tsmc") for d in ("sine", "square")),
        "rig/excavator-link",
        "rig/excavator-link-pi",
    }
    assert all(title for title in names.values())
    assert 'base = "paper/machine"' in scenario_source("paper/sine-pi")
    assert 'mass = "6 kg"' in scenario_source("paper/machine")


def test_a_builtin_text_saved_as_a_file_is_the_same_scenario(scenario) -> None:
    path = scenario(scenario_source("paper/square-tsmc"))
    assert scenario_source(path) == scenario_source("paper/square-tsmc")
    assert_same_block(load_scenario(path), load_scenario(str(path)))
    assert_same_block(load_scenario(str(path)), load_scenario("paper/square-tsmc"))


def toml(values: dict[str, object]) -> str:
    return "".join(f"{path} = {value!r}\n" for path, value in values.items())


def test_what_may_be_missing_is_default(scenario) -> None:
    loop = load_scenario(scenario(toml(LEAST)))
    assert_same_block(loop, example(Loop, controller=PI(100.0), load=Constant()))
    assert_same_block(loop.simulation, Simulation())
    assert_same_block(loop.load, Constant(0.0))
    assert loop.controller.integral_gain == 0.0


@pytest.mark.parametrize("path", LEAST)
def test_what_must_be_there_is_refused_by_name(scenario, path: str) -> None:
    file = scenario(toml({key: value for key, value in LEAST.items() if key != path}))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file)
    table, _, name = path.rpartition(".")
    problem = f"{name} is missing; it must be a finite number"
    if name == "type":
        top = f"a [{table}] table with a type is needed, or a base; it must be "
        problem = top if "." not in table else "a type is needed; it must be "
    assert str(caught.value).startswith(f"{file}: {table}: {problem}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["plant", "valve", "supply", "reference", "controller"])
def test_a_table_that_must_be_there_is_refused_by_name(scenario, name: str) -> None:
    file = scenario(toml({key: value for key, value in LEAST.items() if not key.startswith(f"{name}.")}))
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file)
    needed = f"{name}: a [{name}] table with a type is needed, or a base; it must be one of "
    assert str(caught.value).startswith(f"{file}: {needed}")
    assert type(getattr(example(Loop), name)).__name__ in str(caught.value)


def test_the_observer_of_a_law_is_refused_by_name() -> None:
    law = {path: value for path, value in leaves(example(TSMC)) if "." not in path}
    changes = {"controller": {"type": "TSMC", **law}}
    with pytest.raises(ScenarioError, match=r": controller\.observer: a type is needed; it must be one of "):
        load_scenario("paper/sine-pi", changes)


def test_names_belong_to_roles(scenario) -> None:
    kinds = {"reference.type": "Sine", "load.type": "Sine", "load.amplitude": 100, "load.frequency": 0.25}
    loop = load_scenario(scenario(toml(LEAST | kinds)))
    assert type(loop.reference) is SineReference
    assert type(loop.load) is SineLoad


def test_keys_without_a_type_change_the_default_block(scenario) -> None:
    own = {"load.amplitude": "5 N", "controller.saturation.limit": "5 V"}
    loop = load_scenario(scenario(toml(LEAST | own)))
    assert_same_block(loop.load, Constant(5.0))
    assert_same_block(loop.controller, PI(100.0, saturation=Saturation(5.0)))


def test_keys_without_a_type_change_the_block_of_the_base(scenario) -> None:
    text = 'load.amplitude = "5 N"\ncontroller.type = "TSMC"\ncontroller.observer.exponent = 0.5'
    loop = load_scenario(scenario(on_base(text, "tsmc")))
    assert_same_block(loop.load, example(SineLoad, amplitude=5.0))
    assert_same_block(
        loop.controller, example(TSMC, model=believed(loop), observer=example(TSMObserver, exponent=0.5))
    )


def test_numbers_are_si_and_floats(scenario) -> None:
    text = 'controller.type = "PI"\ncontroller.proportional_gain = 3\nsimulation.substeps = 2'
    loop = load_scenario(scenario(on_base(text)))
    assert repr(loop.controller.proportional_gain) == "3.0"
    assert repr(loop.simulation.substeps) == "2"


def test_crlf_and_a_byte_order_mark_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    text = on_base('[controller]\ntype = "PI"\n').replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert_same_block(load_scenario(path), example(Loop, controller=example(PI)))


def test_the_controller_believes_in_the_nominal_machine(scenario) -> None:
    text = """
        plant.mass = "7 kg"
        valve.gain = 4e-4
        valve.orifice.density = 870
        supply.supply_pressure = "60 bar"
        uncertainty.plant.mass = "10 %"
    """
    loop = load_scenario(scenario(on_base(text, "tsmc")))
    assert loop.plant.mass == pytest.approx(7.7)
    model = loop.controller.model
    assert model.plant.mass == 7.0
    assert model.valve_gain == 4e-4
    assert model.orifice.density == 870.0
    assert model.supply.supply_pressure == 60e5


def test_the_controller_s_model_overrides_single_values(scenario) -> None:
    text = """
        plant.mass = 7
        controller.model.plant.damping = "40 N s/m"
        controller.model.least_drop = "1 bar"
    """
    loop = load_scenario(scenario(on_base(text, "backstepping")))
    assert_same_block(loop.controller.model.plant, loop.plant._replace(damping=40.0))
    assert_same_block(
        loop.controller.model, example(DesignModel, plant=loop.plant._replace(damping=40.0), least_drop=1e5)
    )
    assert loop.plant.damping == 50.0


def test_a_model_of_which_nothing_but_the_type_is_given_is_that_of_the_machine() -> None:
    typed = load_scenario("paper/sine-tsmc", {"controller.model.type": "DesignModel", "plant.mass": 7})
    assert_same_block(typed, load_scenario("paper/sine-tsmc", {"plant.mass": 7}))
    assert typed.controller.model.plant.mass == 7.0


def test_a_law_that_has_no_model_is_given_none(scenario) -> None:
    loop = load_scenario(scenario(on_base("plant.mass = 7\nuncertainty.plant.mass = 0.5")))
    assert model_in(loop.controller) is None
    assert loop.plant.mass == 10.5


def test_changes_take_what_a_file_can_hold() -> None:
    changes = {
        "plant.mass": "7000 g",
        "simulation.period": 1e-3,
        "valve.type": "FirstOrderValve",
        "valve.time_constant": "5 ms",
        "controller": {"saturation": {"limit": "5 V"}},
        "uncertainty.scale": 0,
    }
    loop = load_scenario("paper/sine-pi", changes)
    assert_same_block(loop.plant, example(Loop).plant._replace(mass=7.0))
    assert loop.simulation.period == 1e-3
    assert_same_block(loop.valve, example(FirstOrderValve, time_constant=5e-3))
    assert_same_block(
        loop.controller,
        example(PI)._replace(saturation=example(PI).saturation._replace(limit=5.0)),
    )


def test_another_type_keeps_only_the_keys_that_it_has_too(scenario) -> None:
    law = '[controller]\ntype = "PI"\nproportional_gain = 1\n[controller.saturation]\nlimit = 3'
    path = scenario(on_base(law))
    observer = {"type": "TSMObserver"} | example(TSMObserver)._asdict()
    observer["realisation"] = {"type": "BoundaryLayer"}
    own = {path: value for path, value in leaves(example(TSMC)) if "." not in path}
    changes = {f"controller.{name}": value for name, value in (own | {"observer": observer}).items()}
    loop = load_scenario(path, changes | {"controller.type": "TSMC", "controller.exponent_1": "3/5"})
    assert_same_block(
        loop.controller, example(TSMC, exponent_1=0.6, model=believed(loop), saturation=Saturation(3.0))
    )
    assert load_scenario(path, {"controller.type": "PI"}).controller.proportional_gain == 1.0


def test_a_nested_type_is_changed_alone() -> None:
    loop = load_scenario(
        "paper/sine-tsmc",
        {"controller.observer.realisation.type": "Implicit", "controller.observer.switching_gain_2": 1e5},
    )
    assert_same_block(
        loop.controller.observer, example(TSMObserver, realisation=Implicit(), switching_gain_2=1e5)
    )


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("plant.mass=7", "plant.mass", 7),
        ("plant.mass = 7.5 ", "plant.mass", 7.5),
        ("supply.supply_pressure=40 bar", "supply.supply_pressure", "40 bar"),
        ('supply.supply_pressure="40 bar"', "supply.supply_pressure", "40 bar"),
        ("controller.type=TSMC", "controller.type", "TSMC"),
        ("controller.exponent_1=5/7", "controller.exponent_1", "5/7"),
        ("controller.free=true", "controller.free", True),
        ("uncertainty.scale=-1", "uncertainty.scale", -1),
        ("reference.series.file=a=b.csv", "reference.series.file", "a=b.csv"),
        ("a=1\nb = 2", "a", "1\nb = 2"),
        ("a=" + "[" * 2000, "a", "[" * 2000),
        ("a=" + "9" * 4090, "a", int("9" * 4090)),
    ],
)
def test_overrides_as_text(text: str, path: str, value: object) -> None:
    assert parse_override(text) == (path, value)


@pytest.mark.parametrize(
    "text", ["", "plant.mass", "=7", "a..b=1", ".a=1", "a b=1", "a.=1", "a=" + "9" * 5000]
)
def test_overrides_of_another_form(text: str) -> None:
    with pytest.raises(ScenarioError):
        parse_override(text)


def test_a_period_that_does_not_divide_is_refused_when_simulated() -> None:
    loop = load_scenario("paper/sine-pi", {"simulation.period": "0.3 ms", "simulation.duration": "1 s"})
    with pytest.raises(ParameterError, match=r"simulation\.period = 0\.0003"):
        simulate(loop)


def test_the_import_is_light() -> None:
    heavy = "{'pint', 'pydantic', 'pandas', 'xarray', 'numba'}"
    code = f"import sys, hydroservo.scenario; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_another_type_drops_the_uncertainty_that_it_does_not_have() -> None:
    loop = load_scenario("paper/sine-pi", CYLINDER)
    assert type(loop.plant) is Cylinder
    assert loop.valve.orifice.density == pytest.approx(1.15 * 850.0)
    assert loop.plant.friction.coefficient == example(Cylinder).friction.coefficient
    with pytest.raises(ScenarioError, match=r"uncertainty\.plant\.damping"):
        load_scenario("paper/sine-pi", CYLINDER | {"uncertainty.plant.damping": "20 %"})


RIG = {"sensors.type": "RigSensors", "sensors.position.type": "IdealPosition"}


def test_sensors_know_the_cylinders_areas_unless_told_otherwise() -> None:
    areas = CYLINDER | {"plant.area_a": "20 cm^2", "plant.area_b": "12 cm^2"}
    sensors = load_scenario("paper/sine-pi", areas | RIG).sensors
    assert (sensors.area_a, sensors.area_b) == (20e-4, 12e-4)
    inner = {
        "sensors.type": "DelayedSensors",
        "sensors.sensors.type": "RigSensors",
        "sensors.sensors.position.type": "IdealPosition",
        "sensors.sensors.area_a": 1e-3,
    }
    sensors = load_scenario("paper/sine-pi", areas | inner).sensors.sensors
    assert (sensors.area_a, sensors.area_b) == (1e-3, 12e-4)
    symmetric = load_scenario("paper/sine-pi", RIG | {"plant.piston_area": "6 cm^2"})
    assert (symmetric.sensors.area_a, symmetric.sensors.area_b) == (6e-4, 6e-4)


def test_an_empty_table_among_overrides_is_left_as_it_was_given() -> None:
    given: dict[str, object] = {}
    loop = load_scenario("paper/sine-pi", {"plant": given, "plant.mass": 5.0})
    assert loop.plant.mass == 5.0
    assert given == {}
