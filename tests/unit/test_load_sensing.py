"""The pump that delivers no more pressure than the load takes."""

import pytest

from hydroservo.drives import LoadSensing, LoadSensingState, PressureCompensator, ValveOnSupplyState
from hydroservo.signals import Feed, Pressures
from hydroservo.valves import Orifice

PUMP = LoadSensing(margin=20e5, time_constant=0.05)
INNER = ValveOnSupplyState()


def feed(opening: float) -> Feed:
    return Feed(0.0, Orifice(0.6, 0.02, 850.0), opening, Pressures(120e5, 1e5))


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
    assert PUMP.power(state, feed(5e-4), flows) == 60e5 * flows.supply


def test_it_feeds_a_compensator() -> None:
    """The pump's margin is what compensator and edge share: 12 of 20 bar are throttled."""
    compensated = PUMP._replace(drive=PressureCompensator(8e5))
    state = LoadSensingState(60e5, compensated.drive.init())
    flows = compensated.flows(state, feed(5e-4), 40e5, 10e5)
    alone = PressureCompensator(8e5).flows(compensated.drive.init(), feed(5e-4), 40e5, 10e5)
    assert flows == alone
    assert compensated.power(state, feed(5e-4), flows) == 60e5 * flows.supply


def test_it_begins_at_its_margin() -> None:
    assert PUMP.init().pressure == 20e5
