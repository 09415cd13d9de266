"""The four edges against the formulas and numbers of Merritt, Hydraulic Control Systems, 1967, ch. 5."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from hydroservo.core.signals import Pressures
from hydroservo.machine.valves import FourEdges
from hydroservo.testing.examples import example

SUPPLY = 70e5
SHARP = example(FourEdges, clearance=0.0, transition_drop=0.0)
SIZE = SHARP.discharge_coefficient * SHARP.area_gradient * math.sqrt(SUPPLY / SHARP.density)
UNDERLAP = 5e-5
OPEN = SHARP._replace(lap=-UNDERLAP)


def slope(function: Callable[[float], float], at: float, step: float) -> float:
    return (function(at + step) - function(at - step)) / (2.0 * step)


def flow_gain(edges: FourEdges, opening: float = 0.0) -> float:
    return slope(lambda x: edges.flow(x, SUPPLY, 0.0), opening, 1e-8)


def flow_pressure_coefficient(edges: FourEdges) -> float:
    return -slope(lambda load: edges.flow(0.0, SUPPLY, load), 0.0, 1e-4 * SUPPLY)


def leakage(edges: FourEdges, supply: float) -> float:
    return edges.port_flows(0.0, Pressures(supply, 0.0), 0.5 * supply, 0.5 * supply).supply


def blocked_load_pressure(edges: FourEdges, opening: float) -> float:
    """p_A - p_B with both ports blocked."""
    line = Pressures(SUPPLY, 0.0)
    a, b = (
        brentq(lambda p, port=port: port(edges.port_flows(opening, line, p, p)), 0.0, SUPPLY, xtol=1e-6)
        for port in (lambda flows: flows.a, lambda flows: flows.b)
    )
    return float(a - b)


def test_critical_centre() -> None:
    assert flow_gain(SHARP) == pytest.approx(SIZE, rel=1e-12)
    assert flow_pressure_coefficient(SHARP) == 0.0
    assert leakage(SHARP, SUPPLY) == 0.0


def test_open_centre() -> None:
    assert flow_gain(OPEN) == pytest.approx(2.0 * SIZE, rel=1e-9)
    assert flow_pressure_coefficient(OPEN) == pytest.approx(SIZE * UNDERLAP / SUPPLY, rel=1e-7)
    assert leakage(OPEN, SUPPLY) == pytest.approx(2.0 * SIZE * UNDERLAP, rel=1e-12)
    sensitivity = blocked_load_pressure(OPEN, 1e-3 * UNDERLAP) / (1e-3 * UNDERLAP)
    assert sensitivity == pytest.approx(2.0 * SUPPLY / UNDERLAP, rel=1e-5)


def test_flow_gain_doubles_inside_the_underlap_only() -> None:
    for share in (-0.9, 0.5, 0.9):
        assert flow_gain(OPEN, share * UNDERLAP) == pytest.approx(2.0 * SIZE, rel=1e-9)
    for share in (-3.0, 1.1):
        assert flow_gain(OPEN, share * UNDERLAP) == pytest.approx(SIZE, rel=1e-9)


def test_closed_centre() -> None:
    closed = SHARP._replace(lap=UNDERLAP)
    assert flow_gain(closed, 0.9 * UNDERLAP) == 0.0
    assert flow_gain(closed, 1.1 * UNDERLAP) == pytest.approx(SIZE, rel=1e-9)


def test_a_clearance_leaves_the_flow_gain_of_a_critical_centre_and_bounds_its_pressure_sensitivity() -> None:
    edges = SHARP._replace(clearance=4e-6)
    assert flow_gain(edges) == pytest.approx(SIZE, rel=1e-9)
    sensitivity = blocked_load_pressure(edges, 1e-9) / 1e-9
    assert sensitivity == pytest.approx(SUPPLY / 4e-6, rel=1e-3)


@given(lap=st.floats(-1e-4, 1e-5), clearance=st.floats(1e-6, 1e-5), transition=st.floats(0.0, 5e6))
def test_the_leakage_curve_tells_the_flow_pressure_coefficient(
    lap: float, clearance: float, transition: float
) -> None:
    """K_c = dQ_leakage/dp_s at null, for any matched and symmetric edges."""
    edges = example(FourEdges, lap=lap, clearance=clearance, transition_drop=transition)
    wanted = slope(lambda supply: leakage(edges, supply), SUPPLY, 1e-4 * SUPPLY)
    assert flow_pressure_coefficient(edges) == pytest.approx(wanted, rel=1e-6)


def test_the_published_efficiency_of_a_servo_valve() -> None:
    """Most power goes to the load at p_L = 2/3 p_s, where it is 38.5 % of what the supply was built for.

    The book's numbers are for critical edges without leakage. Of the default ones, the laminar transition at
    1 bar takes 0.2 % and moves the best load pressure by as much.
    """
    for edges, deviation in ((SHARP, 1e-4), (example(FourEdges), 4e-3)):
        largest = edges.flow(5e-3, SUPPLY, 0.0) * SUPPLY
        found = minimize_scalar(
            lambda load, edges=edges: -load * edges.flow(5e-3, SUPPLY, load),
            bounds=(0.0, SUPPLY),
            method="bounded",
            options={"xatol": 1.0},
        )
        assert found.x / SUPPLY == pytest.approx(2.0 / 3.0, rel=deviation)
        assert -found.fun / largest == pytest.approx(0.385, abs=5e-4 + 0.385 * deviation)
