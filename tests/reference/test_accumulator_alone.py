"""A charged bladder as the only supply of an axis, as an emergency function has it."""

from pathlib import Path

import pytest

from hydroservo import load_scenario, simulate
from hydroservo.runs.mismatches import mismatch_cautions

AXIS = """
simulation = { duration = "0.45 s", period = "1 ms", substeps = "auto" }
controls = { type = "Command" }
controller = { type = "OpenLoop" }
reference = { type = "Step", initial = "0 V", final = "10 V", time = "0.1 s" }
load = { type = "Constant", amplitude = "1000 N" }

[start.given]
supply.pressure = "210 bar"

[supply]
type = "PumpSupply"
displacement = "1 mm^3/rad"
demanded_speed = "0 rad/s"
max_torque = "1 N m"
inertia = "1e-3 kg m^2"
speed_gain = "1 N m s/rad"
volume = "0.5 L"
bulk_modulus = "14000 bar"
relief = { type = "ReliefValve", cracking_pressure = "300 bar", gradient = "1 L/(min bar)" }
accumulator = { type = "GasAccumulator", precharge = "16.33368 bar", gas_volume = "10 L", exponent = 1.2 }

[plant]
type = "Cylinder.from_diameters"
bore = "50 mm"
rod = "22 mm"
stroke = "200 mm"
start_position = "0 mm"
start_pressure_a = "5.09 bar"
start_pressure_b = "0 bar"
mechanism = { type = "MassSpringDamper", mass = "2 kg", stiffness = "120 kN/m", rest_position = "0 mm" }
oil = { type = "ConstantOil", effective_bulk_modulus = "14000 bar" }

[valve]
type = "StaticValve"
gain = "0.5 mm/V"
max_opening = "5 mm"

[valve.orifice]
type = "FourEdges"
discharge_coefficient = 1.0
density = 890
clearance = 0
transition_drop = "0.1 bar"
area_gradient = "1.131751945532807e-3 m"
area_ratio_b = 0.99421269617
"""
# By scipy, to a relative tolerance of 1e-8, from the equations as they are printed.
RIGHT = {
    "plant.position": 139.495e-3,
    "plant.velocity": 0.30167,
    "plant.pressure_a": 116.308e5,
    "plant.pressure_b": 32.202e5,
    "supply.pressure": 165.388e5,
}


def loop(folder: Path, **changes: object):
    file = folder / "axis.toml"
    file.write_text(AXIS, encoding="utf-8")
    return load_scenario(file, changes)


@pytest.mark.filterwarnings("ignore:the pressure in a chamber fell:hydroservo.HydroservoWarning")
def test_it_empties_as_an_independent_integration_says(tmp_path: Path) -> None:
    run = simulate(loop(tmp_path))
    assert {path: float(run[path][-1]) for path in RIGHT} == pytest.approx(RIGHT, rel=2e-5)


def test_the_start_pressures_are_found_from_the_charge(tmp_path: Path) -> None:
    charged = {"plant.start_pressure_a": "auto", "plant.start_pressure_b": "auto"}
    first = simulate(loop(tmp_path, **charged, **{"simulation.duration": 0.12})).isel(time=0)
    assert float(first["plant.pressure_a"] + first["plant.pressure_b"]) == pytest.approx(210e5)


def test_one_that_is_not_charged_is_warned_of(tmp_path: Path) -> None:
    file = tmp_path / "empty.toml"
    file.write_text(AXIS.replace("[start.given]\nsupply.pressure", "# supply.pressure"), encoding="utf-8")
    empty = load_scenario(file, {"simulation.duration": 0.12, "plant.start_pressure_a": 0.0})
    said = mismatch_cautions(empty)
    assert said == ["the supply starts at 0 bar; give what it is charged to: start.given.supply.pressure"]
