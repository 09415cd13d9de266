"""The compensator that keeps the drop over the metering edge."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ParameterError
from hydroservo.core.signals import Feed, Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.drives import Hoses, PressureCompensator, PumpDrive, ValveOnSupplyState
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example

EDGES = Orifice(0.6, 0.02, 850.0)
COMPENSATOR = PressureCompensator(8e5)
STATE = ValveOnSupplyState()
METERED = 0.6 * 0.02 * 5e-4 * math.sqrt(2.0 * 8e5 / 850.0)


def feed(opening: float) -> Feed:
    return Feed(0.0, EDGES, opening, Pressures(120e5, 1e5))


@given(st.floats(0.0, 112e5))
def test_the_load_does_not_change_what_is_metered(load: float) -> None:
    assert COMPENSATOR.flows(STATE, feed(5e-4), load, 2e5).a == pytest.approx(METERED)
    assert COMPENSATOR.flows(STATE, feed(-5e-4), 2e5, load).b == pytest.approx(-METERED)


def test_beyond_the_supply_the_drop_is_what_is_left() -> None:
    assert COMPENSATOR.flows(STATE, feed(5e-4), 118e5, 2e5).a == pytest.approx(0.5 * METERED)


def test_all_its_oil_is_drawn_at_the_supplys_pressure() -> None:
    flows = COMPENSATOR.flows(STATE, feed(5e-4), 20e5, 2e5)
    assert COMPENSATOR.power(STATE, feed(5e-4), flows, 0.0, 0.0) == 120e5 * flows.supply


def test_without_opening_it_stands_at_the_tank_and_its_spring() -> None:
    assert COMPENSATOR.compensated(feed(0.0), 50e5, 50e5).line == Pressures(9e5, 1e5)


@pytest.mark.parametrize("inner", [example(PumpDrive), example(Hoses, drive=example(PumpDrive))])
def test_a_pump_in_the_valves_place_behind_it_is_refused(inner: Hoses | PumpDrive) -> None:
    with pytest.raises(
        ParameterError, match=f"drive = '{type(inner).__name__}': stands in the valve's place"
    ):
        checked(COMPENSATOR._replace(drive=inner))
    checked(COMPENSATOR._replace(drive=example(Hoses)))
