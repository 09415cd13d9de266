"""The pump that delivers no more pressure than the load takes."""

import pytest

from hydroservo import Loop, ParameterError
from hydroservo.core.hooks import resting
from hydroservo.core.signals import Feed, Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.drives import (
    Hoses,
    LoadSensing,
    LoadSensingState,
    PressureCompensator,
    PumpDrive,
    ValveOnSupplyState,
)
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example

PUMP = LoadSensing(margin=20e5, time_constant=0.05)
INNER = ValveOnSupplyState()


LINE = Pressures(120e5, 1e5)


def feed(opening: float) -> Feed:
    return Feed(0.0, Orifice(0.6, 0.02, 850.0), opening, LINE)


@pytest.mark.parametrize(
    ("opening", "wanted"), [(5e-4, 60e5), (-5e-4, 30e5), (0.0, 21e5)], ids=["a", "b", "standby"]
)
def test_it_settles_a_margin_above_the_load(opening: float, wanted: float) -> None:
    rate = PUMP.deriv(LoadSensingState(50e5, INNER), feed(opening), 40e5, 10e5)
    assert rate.pressure == pytest.approx((wanted - 50e5) / 0.05)
    assert PUMP.deriv(LoadSensingState(wanted, INNER), feed(opening), 40e5, 10e5).pressure == 0.0


def test_it_goes_no_higher_than_the_supply() -> None:
    assert PUMP.deriv(LoadSensingState(120e5, INNER), feed(5e-4), 110e5, 0.0).pressure == 0.0
    assert PUMP.delivered(LoadSensingState(150e5, INNER), feed(5e-4)).line.supply == 120e5


def test_what_it_draws_is_its_own_pressure_times_its_flow() -> None:
    state = LoadSensingState(60e5, INNER)
    flows = PUMP.flows(state, feed(5e-4), 40e5, 10e5)
    assert flows.supply > 0.0
    assert PUMP.power(state, feed(5e-4), flows, 0.0, 0.0) == 60e5 * flows.supply


def test_it_feeds_a_compensator() -> None:
    """The pump's margin is what compensator and edge share: 12 of 20 bar are throttled."""
    compensated = PUMP._replace(drive=PressureCompensator(8e5))
    state = LoadSensingState(60e5, compensated.drive.init())
    flows = compensated.flows(state, feed(5e-4), 40e5, 10e5)
    alone = PressureCompensator(8e5).flows(compensated.drive.init(), feed(5e-4), 40e5, 10e5)
    assert flows == alone
    assert compensated.power(state, feed(5e-4), flows, 0.0, 0.0) == 60e5 * flows.supply


def test_a_start_that_is_left_open_is_that_of_standby() -> None:
    """Its margin above the tank, where it stays with the spool at 0."""
    started = PUMP.at_rest(LINE, 40e5, 10e5).init()
    assert started.pressure == 21e5
    assert PUMP.deriv(started, feed(0.0), 40e5, 10e5).pressure == 0.0
    assert PUMP.at_rest(Pressures(15e5, 1e5), 40e5, 10e5).init().pressure == 15e5
    assert PUMP._replace(start_pressure=50e5).at_rest(LINE, 40e5, 10e5).init().pressure == 50e5


def test_a_loop_finds_its_start() -> None:
    supply = IdealSupply(60e5, 3e5)
    loop = resting(example(Loop, plant=example(Cylinder), supply=supply, drive=PUMP))
    assert loop.drive.init().pressure == 23e5


def test_what_lies_behind_it_begins_on_its_pressure() -> None:
    """Another such pump behind the hoses there, for which this one's pressure is the most it may reach."""
    inner = example(Hoses, drive=LoadSensing(margin=30e5, time_constant=0.05))
    found = PUMP._replace(drive=inner).at_rest(LINE, 40e5, 10e5)
    assert found.drive.drive.init().pressure == 21e5


@pytest.mark.parametrize("inner", [example(PumpDrive), example(Hoses, drive=example(PumpDrive))])
def test_a_pump_in_the_valves_place_behind_it_is_refused(inner: Hoses | PumpDrive) -> None:
    with pytest.raises(
        ParameterError, match=f"drive = '{type(inner).__name__}': stands in the valve's place"
    ):
        checked(PUMP._replace(drive=inner))
    checked(PUMP._replace(drive=example(Hoses)))
