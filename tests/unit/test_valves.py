"""Valves at points where the answer is plain; laws over all sizes are in the properties."""

import math

import pytest

from hydroservo.valves import FirstOrderValve, FirstOrderValveState, Orifice, StaticValve, StaticValveState

REST = StaticValveState()


def test_the_orifice_is_equation_2() -> None:
    flow = Orifice(0.6, 0.02, 800.0).flow(1e-3, 4e6, 8e5)
    assert flow == pytest.approx(0.6 * 0.02 * 1e-3 * math.sqrt((4e6 - 8e5) / 800.0), rel=1e-15)


def test_the_load_helps_the_flow_the_other_way() -> None:
    edges = Orifice()
    assert edges.flow(-1e-3, 4e6, 1e6) == pytest.approx(-math.sqrt(5e6 / 3e6) * edges.flow(1e-3, 4e6, 1e6))


def test_a_closed_orifice_passes_nothing() -> None:
    assert Orifice().flow(0.0, 4e6, 1e6) == 0.0


def test_flow_per_opening_is_the_slope_of_the_flow() -> None:
    edges = Orifice()
    assert edges.flow(2e-3, 4e6, 0.0) == pytest.approx(2e-3 * edges.flow_per_opening(4e6), rel=1e-15)


@pytest.mark.parametrize(
    ("u", "opening"), [(0.0, 0.0), (2.0, 1e-3), (10.0, 5e-3), (11.0, 5e-3), (-99.0, -5e-3)]
)
def test_static_spool(u: float, opening: float) -> None:
    assert StaticValve().opening(REST, u) == pytest.approx(opening, rel=1e-15)


def test_a_static_spool_remembers_nothing() -> None:
    assert StaticValve().init() == REST
    assert StaticValve().deriv(REST, 1.0) == REST


def test_a_lagging_spool_starts_closed_and_follows_the_command_it_had() -> None:
    valve = FirstOrderValve()
    assert valve.init() == FirstOrderValveState(0.0)
    assert valve.opening(FirstOrderValveState(1e-3), -10.0) == 1e-3
    assert valve.deriv(valve.init(), 1.0).opening == pytest.approx(5e-4 / 0.01)
    assert valve.deriv(FirstOrderValveState(5e-4), 1.0).opening == 0.0
