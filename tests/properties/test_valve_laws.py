"""What every valve and limit must do, whatever its size."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.control.controllers import Saturation
from hydroservo.machine.valves import (
    FirstOrderValve,
    FirstOrderValveState,
    Orifice,
    StaticValve,
    StaticValveState,
)
from hydroservo.testing.examples import example

openings = st.floats(-5e-3, 5e-3)
pressures = st.floats(-5e7, 5e7)
supplies = st.floats(0.0, 5e7)
positive = st.floats(-3.0, 3.0).map(lambda power: 10.0**power)
orifices = st.builds(
    lambda c, w, rho: Orifice(0.62 * c, 0.024 * w, 850.0 * rho), positive, positive, st.floats(0.5, 2.0)
)


@given(edges=orifices, opening=openings, supply=supplies, load=pressures)
def test_flow_has_the_sign_of_the_opening(edges: Orifice, opening: float, supply: float, load: float) -> None:
    flow = edges.flow(opening, supply, load)
    assert flow * opening >= 0.0
    if abs(load) < supply and abs(opening) > 1e-12:
        assert flow != 0.0


@given(edges=orifices, opening=openings, supply=supplies, load=pressures)
def test_flow_is_odd(edges: Orifice, opening: float, supply: float, load: float) -> None:
    """Spool and load reversed, the flow is reversed."""
    assert edges.flow(-opening, supply, -load) == -edges.flow(opening, supply, load)


@given(edges=orifices, pair=st.tuples(openings, openings).map(sorted), supply=supplies, load=pressures)
def test_flow_rises_with_the_opening(edges: Orifice, pair: list[float], supply: float, load: float) -> None:
    assert edges.flow(pair[0], supply, load) <= edges.flow(pair[1], supply, load)


@given(
    edges=orifices,
    opening=st.floats(0.0, 5e-3),
    pair=st.tuples(supplies, supplies).map(sorted),
    load=pressures,
)
def test_flow_rises_with_the_supply(edges: Orifice, opening: float, pair: list[float], load: float) -> None:
    assert edges.flow(opening, pair[0], load) <= edges.flow(opening, pair[1], load)


@given(edges=orifices, opening=openings, supply=supplies, pair=st.tuples(pressures, pressures).map(sorted))
def test_flow_falls_with_the_load(edges: Orifice, opening: float, supply: float, pair: list[float]) -> None:
    assert edges.flow(opening, supply, pair[0]) >= edges.flow(opening, supply, pair[1])


@given(edges=orifices, opening=openings, supply=supplies, load=pressures)
def test_edges_are_passive(edges: Orifice, opening: float, supply: float, load: float) -> None:
    """They give the load no more power than they draw from the supply."""
    flow = edges.flow(opening, supply, load)
    assert flow * load <= abs(flow) * supply


@given(edges=orifices, opening=openings, supply=supplies, excess=st.floats(1.0, 1e8))
def test_no_flow_against_a_load_above_the_supply(
    edges: Orifice, opening: float, supply: float, excess: float
) -> None:
    assert edges.flow(opening, supply, math.copysign(supply + excess, opening)) == 0.0


@given(u=st.floats(allow_nan=False), gain=positive, limit=positive)
def test_a_static_spool_stays_within_its_limit(u: float, gain: float, limit: float) -> None:
    valve = example(StaticValve, gain, limit)
    opening = valve.opening(StaticValveState(), u)
    assert abs(opening) <= limit
    assert opening == (math.copysign(limit, u) if abs(gain * u) > limit else gain * u)


@given(u=st.floats(allow_nan=False), side=st.sampled_from([-1.0, 1.0]), share=st.floats(0.0, 1.0))
def test_a_lagging_spool_never_leaves_its_limit(u: float, side: float, share: float) -> None:
    """At the limit it does not move outwards, and inside it moves towards the command."""
    valve = example(FirstOrderValve)
    assert side * valve.deriv(FirstOrderValveState(side * valve.max_opening), u).opening <= 0.0
    inside = share * side * valve.max_opening
    commanded = min(max(valve.gain * u, -valve.max_opening), valve.max_opening)
    rate = valve.deriv(FirstOrderValveState(inside), u).opening
    assert rate == pytest.approx((commanded - inside) / valve.time_constant, rel=1e-15)


@given(u=st.floats(allow_nan=False), limit=positive)
def test_saturation_holds_the_command_within_its_limit(u: float, limit: float) -> None:
    held = Saturation(limit).apply(u)
    assert abs(held) <= limit
    assert held == u or (abs(u) > limit and held == math.copysign(limit, u))


def test_saturation_lets_not_a_number_through() -> None:
    """So that a law that fails is seen to fail."""
    assert math.isnan(Saturation().apply(math.nan))
