"""Valves at points where the answer is plain; laws over all sizes are in the properties."""

import math

import pytest

from hydroservo import ParameterError
from hydroservo.machine.valves import (
    FirstOrderValve,
    FirstOrderValveState,
    Orifice,
    StaticValve,
    StaticValveState,
)
from hydroservo.testing.examples import example

REST = StaticValveState()


def test_the_orifice_is_equation_2() -> None:
    flow = Orifice(0.6, 0.02, 800.0).flow(1e-3, 4e6, 8e5)
    assert flow == pytest.approx(0.6 * 0.02 * 1e-3 * math.sqrt((4e6 - 8e5) / 800.0), rel=1e-15)


def test_the_load_helps_the_flow_the_other_way() -> None:
    edges = example(Orifice)
    assert edges.flow(-1e-3, 4e6, 1e6) == pytest.approx(-math.sqrt(5e6 / 3e6) * edges.flow(1e-3, 4e6, 1e6))


def test_a_closed_orifice_passes_nothing() -> None:
    assert example(Orifice).flow(0.0, 4e6, 1e6) == 0.0


def test_flow_per_opening_is_the_slope_of_the_flow() -> None:
    edges = example(Orifice)
    assert edges.flow(2e-3, 4e6, 0.0) == pytest.approx(2e-3 * edges.flow_per_opening(4e6), rel=1e-15)


@pytest.mark.parametrize(
    ("u", "opening"), [(0.0, 0.0), (2.0, 1e-3), (10.0, 5e-3), (11.0, 5e-3), (-99.0, -5e-3)]
)
def test_static_spool(u: float, opening: float) -> None:
    assert example(StaticValve).opening(REST, u) == pytest.approx(opening, rel=1e-15)


def test_a_static_spool_remembers_nothing() -> None:
    assert example(StaticValve).init() == REST
    assert example(StaticValve).deriv(REST, 1.0) == REST


def test_a_lagging_spool_starts_closed_and_follows_the_command_it_had() -> None:
    valve = example(FirstOrderValve)
    assert valve.init() == FirstOrderValveState(0.0)
    assert valve.opening(FirstOrderValveState(1e-3), -10.0) == 1e-3
    assert valve.deriv(valve.init(), 1.0).opening == pytest.approx(5e-4 / 0.01)
    assert valve.deriv(FirstOrderValveState(5e-4), 1.0).opening == 0.0


def test_a_lagging_spool_from_its_corner() -> None:
    """The transfer function of its right side at the corner: amplitude 1/sqrt(2), 45 degrees late."""
    valve = FirstOrderValve.from_corner(40.0, gain=2e-4, max_opening=1e-3, orifice=example(Orifice, 0.7))
    of_opening = valve.deriv(FirstOrderValveState(1e-6), 0.0).opening / 1e-6
    of_command = valve.deriv(FirstOrderValveState(0.0), 1e-3).opening / 1e-3
    response = of_command / (2j * math.pi * 40.0 - of_opening) / 2e-4
    assert abs(response) == pytest.approx(math.sqrt(0.5), rel=1e-12)
    assert math.degrees(math.atan2(response.imag, response.real)) == pytest.approx(-45.0, rel=1e-12)
    assert (valve.max_opening, valve.orifice) == (1e-3, example(Orifice, 0.7))


@pytest.mark.parametrize("corner", [0.0, -10.0, math.nan])
def test_a_corner_is_a_frequency(corner: float) -> None:
    with pytest.raises(ParameterError, match=r"corner_frequency = .*must be above 0"):
        FirstOrderValve.from_corner(corner, 5e-4, 5e-3, example(Orifice))
