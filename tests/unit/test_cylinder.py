"""The cylinder with two chambers against its equations."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import Loop, Simulation, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.wiring import believed
from hydroservo.core.hooks import at_rest
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.drives import open_ports
from hydroservo.machine.mechanics import (
    LuGre,
    Mass,
    NoStops,
    OneLinkArm,
    Stops,
    Stribeck,
    StribeckState,
    Viscous,
)
from hydroservo.machine.oils import AeratedOil, ConstantOil
from hydroservo.machine.plants import Cylinder, CylinderState, LoadPressurePlant
from hydroservo.machine.valves import Orifice
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

DIFFERENTIAL = Cylinder(
    area_a=2e-3,
    area_b=1e-3,
    stroke=0.5,
    dead_volume_a=1e-4,
    dead_volume_b=2e-4,
    internal_leakage=1e-12,
    external_leakage=2e-12,
    start_position=0.1,
    oil=ConstantOil(1e9),
    friction=Viscous(100.0),
    mechanism=Mass(20.0),
)


def test_rates() -> None:
    state = CylinderState(0.1, 0.3, 5e6, 3e6, DIFFERENTIAL.friction.init())
    rate = DIFFERENTIAL.deriv(state, PortFlows(3e-4, 2e-4, 0.0, 0.0), 500.0)
    assert rate.velocity == pytest.approx((2e-3 * 5e6 - 1e-3 * 3e6 - 500.0 - 10.0) / 20.0)
    assert rate.position == 0.1
    into_a = 3e-4 - 2e-3 * 0.1 - 1e-12 * 2e6 - 2e-12 * 5e6
    into_b = 1e-3 * 0.1 - 2e-4 + 1e-12 * 2e6 - 2e-12 * 3e6
    assert rate.pressure_a == pytest.approx(1e9 / (1e-4 + 2e-3 * 0.3) * into_a)
    assert rate.pressure_b == pytest.approx(1e9 / (2e-4 + 1e-3 * 0.2) * into_b)


def test_nothing_leaks_in_from_outside() -> None:
    leaky = DIFFERENTIAL._replace(internal_leakage=0.0)
    state = CylinderState(0.0, 0.3, -5e4, -5e4, leaky.friction.init())
    rate = leaky.deriv(state, PortFlows(0.0, 0.0, 0.0, 0.0), 0.0)
    assert rate.pressure_a == rate.pressure_b == 0.0


def test_friction_sees_all_other_forces() -> None:
    """A stuck piston is held against the pressures, the load and the mechanism together."""
    stuck = DIFFERENTIAL._replace(
        friction=example(Stribeck, 40.0, 60.0), mechanism=example(OneLinkArm), stops=NoStops()
    )
    weight = example(OneLinkArm).resistance(0.05, 0.0)
    state = CylinderState(0.0, 0.05, 1e6, 1e6, StribeckState())
    for excess, moves in ((0.0, False), (59.0, False), (-59.0, False), (61.0, True), (-61.0, True)):
        rate = stuck.deriv(state, PortFlows(0.0, 0.0, 0.0, 0.0), 1e3 - weight + excess)
        assert (abs(rate.velocity) > 1e-10) is moves


def test_stops_push_it_back() -> None:
    state = CylinderState(0.0, -1e-5, 1e6, 2e6, DIFFERENTIAL.friction.init())
    rate = DIFFERENTIAL._replace(stops=Stops(1e8, 5.0)).deriv(state, PortFlows(0.0, 0.0, 0.0, 0.0), 0.0)
    assert rate.velocity == pytest.approx(1e8 * 1e-5 / 20.0)


@given(x=st.floats(-10.0, 10.0))
def test_volumes_stay_positive(x: float) -> None:
    cylinder = example(Cylinder, stops=NoStops())
    assert cylinder.volume_a(x) >= 0.01 * cylinder.dead_volume_a
    assert cylinder.volume_b(x) >= 0.01 * cylinder.dead_volume_b


def test_it_takes_the_port_flows_of_the_edges() -> None:
    state = CylinderState(0.1, 0.3, 2.5e6, 1.5e6, DIFFERENTIAL.friction.init())
    line = Pressures(40e5, 1e5)
    assert DIFFERENTIAL.flows(state, open_ports(example(Orifice), 1e-4, line)) == example(Orifice).port_flows(
        1e-4, line, 2.5e6, 1.5e6
    )
    seen = DIFFERENTIAL.outputs(state, line, 0.0)
    assert seen == (0.1, 2e-3 * 2.5e6 - 1e-3 * 1.5e6, 0.3, 2.5e6, 1.5e6, 0.0)


def test_the_defaults_are_the_paper_s_machine() -> None:
    cylinder, plant = example(Cylinder), example(LoadPressurePlant)
    simple = cylinder.simplified()
    for name in LoadPressurePlant._fields:
        assert getattr(simple, name) == pytest.approx(getattr(plant, name), rel=1e-12), name
    assert cylinder.volume_a(0.039) == pytest.approx(0.5 * plant.total_volume)
    assert cylinder.volume_b(0.039) == pytest.approx(0.5 * plant.total_volume)
    assert cylinder.at_rest(Pressures(40e5, 0.0), 0.0).init()[2:4] == (20e5, 20e5)


def test_simplified_keeps_the_natural_frequency() -> None:
    arm = example(OneLinkArm)
    started = DIFFERENTIAL._replace(start_pressure_a=30e5, start_pressure_b=10e5)
    simple = started._replace(mechanism=arm, oil=AeratedOil()).simplified()
    spring = 4e-6 / (1e-4 + 2e-3 * 0.1) + 1e-6 / (2e-4 + 1e-3 * 0.4)
    assert 4.0 * simple.piston_area**2 / simple.total_volume == pytest.approx(spring)
    assert simple.piston_area == pytest.approx(1.5e-3)
    assert simple.mass == arm.inertia(0.1)
    assert simple.bulk_modulus == AeratedOil().bulk_modulus(20e5)
    assert simple.leakage == pytest.approx(2e-12)
    assert simple.damping == 100.0


def test_from_diameters() -> None:
    single = Cylinder.from_diameters(0.05, 0.03, 0.4, AeratedOil(), Mass(6.0))
    assert single.area_a == pytest.approx(math.pi * 0.025**2)
    assert single.area_b == pytest.approx(math.pi * (0.025**2 - 0.015**2))
    assert (single.stroke, single.start_position) == (0.4, 0.2)
    double = Cylinder.from_diameters(
        0.05, 0.03, 0.4, AeratedOil(), Mass(6.0), rods=2, line_volume_a=1e-5, line_volume_b=3e-5
    )
    assert double.area_a == double.area_b == single.area_b
    assert (double.dead_volume_a, double.dead_volume_b) == (1e-5, 3e-5)


SHORT = Simulation(0.02, 1e-4, 5, 1e-3)
FULL = example(Cylinder, oil=AeratedOil(), friction=example(LuGre), mechanism=example(OneLinkArm))
STICKING = example(Cylinder, friction=example(Stribeck), mechanism=example(OneLinkArm))


@pytest.mark.parametrize("plant", [example(Cylinder), FULL, STICKING], ids=["plain", "full", "sticking"])
def test_compiled_and_interpreted_runs_are_the_same(plant: Cylinder) -> None:
    loop = example(Loop, simulation=SHORT, plant=plant, controller=PI(0.3, 50.0))
    run = simulate(loop, strict=True)
    assert run.identical(simulate(loop, compiled=False))
    assert np.isfinite(run["plant.pressure_a"]).all()
    assert run["plant.velocity"].std() > 0.0


def test_it_follows_the_demand_as_the_load_pressure_form_does() -> None:
    """Near mid-stroke, where the chambers are alike."""
    paper, here = (
        simulate(
            example(Loop, simulation=Simulation(0.1, 1e-4, 5, 1e-3), plant=plant, controller=PI(0.3, 50.0))
        )
        for plant in (example(LoadPressurePlant), example(Cylinder))
    )
    largest = abs(paper["plant.velocity"]).max()
    assert abs(paper["plant.velocity"] - here["plant.velocity"]).max() < 1e-4 * largest


SCENARIO = """
[plant]
type = "Cylinder"
area_a = "4 cm^2"
area_b = "3 cm^2"
dead_volume_a = "20 cm^3"
dead_volume_b = "20 cm^3"
[plant.oil]
type = "AeratedOil"
air_content = 0.01
[plant.friction]
type = "LuGre"
bristle_stiffness = 1e6
bristle_damping = 80
coulomb = "40 N"
breakaway = "60 N"
stribeck_velocity = "5 mm/s"
viscous = "50 N s/m"
[plant.stops]
type = "NoStops"
[plant.mechanism]
type = "OneLinkArm"
base_distance = "300 mm"
pin_distance = "80 mm"
closed_length = "271.5 mm"
level_angle = "80 deg"
arm_inertia = "0.25 kg m^2"
arm_mass = "2 kg"
centre_distance = "300 mm"
moving_mass = "1 kg"
payload = "3 kg"
reach = "600 mm"
"""


def test_a_scenario_names_its_parts(tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(on_base(SCENARIO), encoding="utf-8")
    loop = load_scenario(file)
    assert isinstance(loop.plant, Cylinder)
    assert_same_block(loop.plant.oil, AeratedOil(air_content=0.01))
    assert_same_block(loop.plant.friction, example(LuGre))
    assert_same_block(loop.plant.stops, NoStops())
    arm = example(OneLinkArm, level_angle=math.radians(80.0))
    assert isinstance(loop.plant.mechanism, OneLinkArm)
    assert loop.plant.mechanism == pytest.approx(arm, rel=1e-14)
    assert loop.plant.area_b == pytest.approx(3e-4)
    assert_same_block(believed(loop).plant, at_rest(loop).simplified())
