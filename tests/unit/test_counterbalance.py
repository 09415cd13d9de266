"""The counterbalance valve."""

import pytest

from hydroservo import ParameterError
from hydroservo.core.signals import Feed, Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.drives import CheckValve, Counterbalance, CounterbalanceState, ValveOnSupplyState
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.valves import NoEdges

VALVE = Counterbalance(
    pilot_ratio=4.0,
    cracking_pressure=200e5,
    opening_range=20e5,
    rated_flow=1e-3,
    rated_drop=25e5,
    check_valve=CheckValve(cracking_pressure=1e5, conductance=1e-9),
    volume=1e-5,
    oil=ConstantOil(1e9),
    transition_drop=0.0,
)
LINE = Pressures(210e5, 0.0)
SHUT = Feed(0.0, NoEdges(), 0.0, LINE)


def state(pressure: float) -> CounterbalanceState:
    return CounterbalanceState(pressure, ValveOnSupplyState())


def test_it_holds_its_load_up_to_its_setting() -> None:
    assert VALVE.flows(state(0.0), SHUT, 199e5, 0.0).a == 0.0
    assert VALVE.flows(state(0.0), SHUT, 201e5, 0.0).a < 0.0


def test_the_pilot_lowers_its_setting_by_the_ratio() -> None:
    """p + R p_X = p_c: at 150 bar of load it takes 12.5 bar."""
    assert VALVE.opening(150e5, 12.5e5, 0.0) == 0.0
    assert VALVE.opening(150e5, 12.5e5 + 1e5, 0.0) == pytest.approx(4e5 / 20e5)
    assert VALVE.opening(150e5, 100e5, 0.0) == 1.0


def test_back_pressure_raises_its_setting_by_one_and_the_ratio() -> None:
    assert VALVE.opening(200e5 + 5.0 * 10e5, 0.0, 10e5) == 0.0
    assert VALVE.opening(200e5 + 5.0 * 10e5 + 2e5, 0.0, 10e5) == pytest.approx(0.1)


def test_wide_open_it_passes_its_rated_flow() -> None:
    assert VALVE.flows(state(100e5), SHUT, 125e5, 210e5).a == pytest.approx(-1e-3)


def test_at_its_rated_drop_it_passes_its_rated_flow_however_wide_the_transition_is() -> None:
    """5 bar, and the transition at its default of 1 bar, which takes 1 % of the root there."""
    valve = VALVE._replace(rated_drop=5e5, transition_drop=Counterbalance._field_defaults["transition_drop"])
    assert valve.flows(state(120e5), SHUT, 125e5, 210e5).a == pytest.approx(-1e-3, rel=1e-12)


def test_a_pilot_that_its_check_valve_would_not_have_is_refused() -> None:
    piloted = VALVE.check_valve._replace(pilot_ratio=3.0)
    with pytest.raises(ParameterError, match=r"check_valve\.pilot_ratio = 3\.0: must be 0"):
        checked(VALVE._replace(check_valve=piloted))
    assert checked(VALVE) == VALVE


def test_it_lets_the_load_rise_freely() -> None:
    assert VALVE.flows(state(150e5), SHUT, 100e5, 0.0).a == pytest.approx(1e-9 * 50e5)


def test_in_line_b_it_is_the_mirror_image() -> None:
    other = VALVE._replace(in_line_b=True)
    a, b = VALVE.flows(state(20e5), SHUT, 150e5, 60e5), other.flows(state(20e5), SHUT, 60e5, 150e5)
    assert (b.b, b.a) == (-a.a, a.b)
    assert other.deriv(state(20e5), SHUT, 60e5, 150e5) == VALVE.deriv(state(20e5), SHUT, 150e5, 60e5)


def test_what_leaks_past_it_is_compressed_behind_it() -> None:
    flow = VALVE.flows(state(20e5), SHUT, 150e5, 60e5).a
    rate = VALVE.deriv(state(20e5), SHUT, 150e5, 60e5)
    assert rate.pressure == pytest.approx(-flow * 1e9 / 1e-5)
    assert rate.pressure > 0.0


def test_it_begins_at_its_chambers_pressure() -> None:
    assert VALVE.at_rest(LINE, 30e5, 5e5).init().pressure == 30e5
    assert VALVE._replace(in_line_b=True).at_rest(LINE, 30e5, 5e5).init().pressure == 5e5
    assert VALVE._replace(start_pressure=1e5).at_rest(LINE, 30e5, 5e5).init().pressure == 1e5
