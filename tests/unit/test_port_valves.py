"""Relief and anti-cavitation valves at the ports."""

import pytest

from hydroservo import Loop, ParameterError, simulate
from hydroservo.core.signals import Feed, Pressures
from hydroservo.machine.drives import CheckValve, Hoses, PortValves
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import LoadPressurePlant
from hydroservo.machine.supplies import ReliefValve
from hydroservo.machine.valves import NoEdges
from hydroservo.runs.run import complete_loop
from hydroservo.testing.examples import example
from tests.support.axes import commanded_axis, step, viscous

TANK = 1e5
SHUT = Feed(0.0, NoEdges(), 0.0, Pressures(40e5, TANK))
VALVES = PortValves(ReliefValve(200e5, 1e-10), CheckValve(3e4, 1e-9))
# Meter-out, with the rod-side edge to the tank shut while the bore side is opened to the supply.
SHUT_IN = {
    "simulation.duration": "1 s",
    "reference": step("0 V", "5 V", "0.1 s"),
    "supply.supply_pressure": "160 bar",
    "plant.bore": "63 mm",
    "plant.rod": "45 mm",
    "plant.stroke": "400 mm",
    "plant.start_position": "200 mm",
    "plant.start_pressure_a": "20 bar",
    "plant.start_pressure_b": "40.8 bar",
    "plant.mechanism.mass": "300 kg",
    "plant.friction": viscous("3000 N s/m"),
    "valve.type": "FirstOrderValve",
    "valve.time_constant": "10 ms",
    "valve.orifice.extra_lap_bt": "0.9 mm",
}
PORTS = {
    "type": "PortValves",
    "relief": {"type": "ReliefValve", "cracking_pressure": "210 bar", "gradient": "1 L/(min bar)"},
    "check_valve": {"type": "CheckValve", "cracking_pressure": "0.3 bar", "conductance": "5 L/(min bar)"},
}


def test_between_vacuum_and_their_setting_they_pass_nothing() -> None:
    assert VALVES.flows(VALVES.init(), SHUT, 200e5 + TANK, 0.8e5) == (0.0, 0.0, 0.0, 0.0)


def test_above_the_setting_oil_goes_to_the_tank() -> None:
    flows = VALVES.flows(VALVES.init(), SHUT, 210e5 + TANK, 220e5 + TANK)
    assert flows == pytest.approx((-1e-4, 2e-4, 0.0, 3e-4))


def test_below_the_tank_oil_comes_from_there() -> None:
    flows = VALVES.flows(VALVES.init(), SHUT, TANK - 2e5, TANK - 3e5)
    assert flows == pytest.approx((2e-4, -3e-4, 0.0, -5e-4))


def test_they_hold_a_port_that_an_area_ratio_raises() -> None:
    """327 bar is what the area ratio gives; with relief valves the axis moves on instead."""
    without, held = (simulate(commanded_axis(SHUT_IN | drive)) for drive in ({}, {"drive": PORTS}))
    ratio = 63.0**2 / (63.0**2 - 45.0**2)
    assert without["plant.pressure_b"][-1] == pytest.approx(160e5 * ratio, rel=1e-3)
    assert 210e5 < held["plant.pressure_b"][-1] < 225e5
    assert held["plant.velocity"][-1] > 0.1
    assert abs(without["plant.velocity"][-1]) < 1e-6


def test_at_the_far_end_of_hoses_they_stand_at_the_valve() -> None:
    hoses = Hoses(2e-5, 2e-5, 1e10, 1e10, ConstantOil(1e9), VALVES)
    state = hoses._replace(start_pressure_a=210e5 + TANK, start_pressure_b=10e5).init()
    assert hoses.deriv(state, SHUT, 210e5 + TANK, 10e5).pressure_a == pytest.approx(-1e-4 * 1e9 / 2e-5)


def test_a_plant_without_chambers_is_refused() -> None:
    with pytest.raises(ParameterError, match="PortValves"):
        complete_loop(example(Loop, plant=example(LoadPressurePlant), drive=VALVES))
