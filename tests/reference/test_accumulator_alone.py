"""A charged bladder as the only supply of an axis, as an emergency function has it."""

import pytest

from hydroservo import simulate
from hydroservo.runs.cautions.loop import mismatch_cautions
from tests.support.axes import commanded_axis, step

CHARGED = {"start": {"given": {"supply.pressure": "210 bar"}}}
AXIS = {
    "simulation.duration": "0.45 s",
    "reference": step("0 V", "10 V", "0.1 s"),
    "load.amplitude": "1000 N",
    "supply": {
        "type": "PumpSupply",
        "displacement": "1 mm^3/rad",
        "demanded_speed": "0 rad/s",
        "max_torque": "1 N m",
        "inertia": "1e-3 kg m^2",
        "speed_gain": "1 N m s/rad",
        "volume": "0.5 L",
        "bulk_modulus": "14000 bar",
        "relief": {"type": "ReliefValve", "cracking_pressure": "300 bar", "gradient": "1 L/(min bar)"},
        "accumulator": {
            "type": "GasAccumulator",
            "precharge": "16.33368 bar",
            "gas_volume": "10 L",
            "exponent": 1.2,
        },
    },
    "plant.bore": "50 mm",
    "plant.start_position": "0 mm",
    "plant.start_pressure_a": "5.09 bar",
    "plant.start_pressure_b": "0 bar",
    "plant.mechanism": {
        "type": "MassSpringDamper",
        "mass": "2 kg",
        "stiffness": "120 kN/m",
        "rest_position": "0 mm",
    },
    "plant.oil.effective_bulk_modulus": "14000 bar",
    "valve": {
        "type": "StaticValve",
        "gain": "0.5 mm/V",
        "max_opening": "5 mm",
        "orifice": {
            "type": "FourEdges",
            "discharge_coefficient": 1.0,
            "density": 890,
            "clearance": 0,
            "transition_drop": "0.1 bar",
            "area_gradient": "1.131751945532807e-3 m",
            "area_ratio_b": 0.99421269617,
        },
    },
}
# By scipy, to a relative tolerance of 1e-8, from the equations as they are printed.
RIGHT = {
    "plant.position": 139.495e-3,
    "plant.velocity": 0.30167,
    "plant.pressure_a": 116.308e5,
    "plant.pressure_b": 32.202e5,
    "supply.pressure": 165.388e5,
}


@pytest.mark.filterwarnings("ignore:the pressure in a chamber fell:hydroservo.HydroservoWarning")
def test_it_empties_as_an_independent_integration_says() -> None:
    run = simulate(commanded_axis(AXIS | CHARGED))
    assert {path: float(run[path][-1]) for path in RIGHT} == pytest.approx(RIGHT, rel=2e-5)


def test_the_start_pressures_are_found_from_the_charge() -> None:
    found = {"plant.start_pressure_a": "auto", "plant.start_pressure_b": "auto"}
    loop = commanded_axis(AXIS | CHARGED | found | {"simulation.duration": 0.12})
    first = simulate(loop).isel(time=0)
    assert float(first["plant.pressure_a"] + first["plant.pressure_b"]) == pytest.approx(210e5)


def test_one_that_is_not_charged_is_warned_of() -> None:
    empty = commanded_axis(AXIS | {"plant.start_pressure_a": 0.0})
    said = mismatch_cautions(empty)
    assert said == ["the supply starts at 0 bar; give what it is charged to: start.given.supply.pressure"]
