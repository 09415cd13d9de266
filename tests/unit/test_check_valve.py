"""The check valve."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo.core.roles import CheckFlow, Relief
from hydroservo.machine.drives import CheckValve
from hydroservo.scenario.role_checks import role_problem

VALVE = CheckValve(cracking_pressure=5e4, conductance=1e-9, opening_range=2e4)


@given(st.floats(-4e7, 5e4))
def test_it_is_shut_up_to_its_cracking_pressure(drop: float) -> None:
    assert VALVE.flow(drop) == 0.0


@given(st.floats(7e4, 4e7))
def test_wide_open_it_is_laminar(drop: float) -> None:
    assert VALVE.flow(drop) == pytest.approx(1e-9 * drop)


def test_it_opens_smoothly() -> None:
    for at, slope in ((5e4, 0.0), (7e4, 1e-9)):
        before, after = ((VALVE.flow(at + h) - VALVE.flow(at)) / h for h in (-1.0, 1.0))
        assert before == pytest.approx(slope, abs=1e-12)
        assert after == pytest.approx(slope, abs=1e-12)
    assert VALVE.flow(6e4) == pytest.approx(0.5 * 1e-9 * 6e4)


@given(st.floats(-1e7, 1e7), st.floats(-1e7, 1e7))
def test_it_makes_no_energy(drop: float, pilot: float) -> None:
    assert drop * VALVE._replace(pilot_ratio=4.0).piloted(drop, pilot) >= 0.0


def test_a_pilot_holds_it_open_for_oil_that_comes_back() -> None:
    valve = VALVE._replace(pilot_ratio=4.0)
    assert valve.piloted(-10e5, 2.6e5) == 0.0
    assert valve.piloted(-10e5, 2.7e5) == pytest.approx(-1e-3)
    assert valve.piloted(-10e5, -50e5) == 0.0


def test_it_is_no_relief_valve() -> None:
    assert role_problem(CheckValve, CheckFlow) is None
    assert role_problem(CheckValve, Relief) == "it says that its role is CheckFlow"
