"""Hoses between what meters and the cylinder."""

import math
from typing import NamedTuple

import pytest

from hydroservo import Loop
from hydroservo.core.hooks import at_ports, resting
from hydroservo.core.roles import Block, Drive, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.machine.drives import Hoses, HosesState, LoadSensing, PumpDrive, ValveOnSupplyState
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.valves import NoEdges
from hydroservo.testing.examples import example

LINE = Pressures(40e5, 0.0)
SHUT = Feed(0.0, NoEdges(), 0.0, LINE)
HOSES = Hoses(2e-5, 3e-5, 1e10, 2e10, ConstantOil(1e9))
STATE = HosesState(30e5, 10e5, ValveOnSupplyState())


def test_the_resistance_lets_through_what_the_drop_drives() -> None:
    flows = HOSES.flows(STATE, SHUT, 20e5, 14e5)
    assert (flows.a, flows.b) == pytest.approx((1e-4, 2e-5))
    assert HOSES.load_flow(STATE, SHUT, 6e5) == pytest.approx(0.5 * ((30 - 23) * 1e-5 + (17 - 10) * 0.5e-5))


def test_behind_a_shut_valve_the_pressures_fall_off_exponentially() -> None:
    """With the chambers' pressures held: p - p_A decays with the time constant R V/beta_e."""
    rate = HOSES.deriv(STATE, SHUT, 20e5, 14e5)
    assert rate.pressure_a == pytest.approx(-10e5 * 1e9 / (2e-5 * 1e10))
    assert rate.pressure_b == pytest.approx(4e5 * 1e9 / (3e-5 * 2e10))


def test_a_hose_is_that_of_hagen_and_poiseuille() -> None:
    hose = Hoses.from_dimensions(3.0, 0.0127, 46e-6, ConstantOil(1e9))
    assert hose.volume_a == hose.volume_b == pytest.approx(math.pi / 4.0 * 0.0127**2 * 3.0)
    mean_speed = 1e-4 / (math.pi / 4.0 * 0.0127**2)
    darcy = 64.0 / (mean_speed * 0.0127 / 46e-6)  # laminar friction factor
    drop = darcy * 3.0 / 0.0127 * 0.5 * 850.0 * mean_speed**2
    assert hose.resistance_a * 1e-4 == pytest.approx(drop)


def test_hoses_of_given_dimensions_may_be_given_their_start() -> None:
    hoses = Hoses.from_dimensions(3.0, 0.0127, 46e-6, ConstantOil(1e9), start_pressure_b=3e5)
    state = hoses.at_rest(LINE, 7e5, 2e5).init()
    assert (state.pressure_a, state.pressure_b) == (7e5, 3e5)


def test_pressures_that_are_left_open_are_those_of_the_chambers() -> None:
    loop = resting(example(Loop, plant=example(Cylinder), drive=HOSES))
    plant, drive = loop.plant.init(), loop.drive.init()
    assert (drive.pressure_a, drive.pressure_b) == (plant.pressure_a, plant.pressure_b)
    given = resting(example(Loop, plant=example(Cylinder), drive=HOSES._replace(start_pressure_b=3e5)))
    assert given.drive.init().pressure_b == 3e5


def test_what_lies_behind_begins_at_the_hoses_pressures() -> None:
    inner = HOSES._replace(drive=example(PumpDrive))
    found = HOSES._replace(start_pressure_a=7e5, drive=inner).at_rest(LINE, 1e5, 2e5)
    assert (found.drive.start_pressure_a, found.drive.start_pressure_b) == (7e5, 2e5)


def test_a_drive_without_a_start_of_its_own_passes_the_pressures_on() -> None:
    found = at_ports(LoadSensing(10e5, 0.02, HOSES), LINE, 7e5, 2e5)
    assert (found.drive.start_pressure_a, found.drive.start_pressure_b) == (7e5, 2e5)
    assert at_ports(example(PumpDrive), LINE, 7e5, 2e5) == example(PumpDrive)


@role(Drive)
class Shafted(NamedTuple):
    """A pump whose shaft takes 1e-4 m^3/s times the rise of the pressures at its own ports."""

    def init(self) -> ValveOnSupplyState:
        return ValveOnSupplyState()

    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block:
        return s

    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        return PortFlows(1e-4, 1e-4, supply=0.0, tank=0.0)

    def power(self, s: Block, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float) -> float:
        return flows.a * pressure_a - flows.b * pressure_b


def test_a_pump_behind_hoses_draws_power_at_its_own_ports() -> None:
    hoses = HOSES._replace(drive=Shafted())
    flows = hoses.flows(STATE, SHUT, 20e5, 14e5)
    assert hoses.power(STATE, SHUT, flows, 20e5, 14e5) == pytest.approx(1e-4 * (30e5 - 10e5))
