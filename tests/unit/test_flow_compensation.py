"""Flow and direction: a single-rod cylinder on a valve with matched edges moves alike both ways."""

import math
from typing import Any

import pytest
from scipy.optimize import root

from hydroservo import ParameterError
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI, DirectionalGain, FlowCompensation
from hydroservo.core.signals import Demand, Measurement, Pressures
from hydroservo.core.validation import checked
from hydroservo.machine.valves import Orifice
from hydroservo.testing.examples import example

SUPPLY, DROP = 120e5, 35e5
AREA_A, AREA_B = 31.2e-4, 15.3e-4  # 63/45 mm
RATIO = AREA_B / AREA_A
EDGES, OPENING_GAIN = example(Orifice), 1e-5
BARE = PI(1.0, controls=Velocity())  # asks for the demand, at a measured velocity of 0


COMPENSATED = FlowCompensation(
    BARE, SUPPLY, AREA_A, AREA_B, rated_drop=DROP, least_drop=1e5, time_constant=0.0
)


def command(law: Any, asked: float, hydraulic_force: float) -> float:
    y = Measurement(0.0, hydraulic_force, 0.0, 0.0, 0.0, 0.0, 0.0)
    u: float = law.step(law.init(), y, Demand(asked, 0.0, 0.0), 1e-3).u
    return u


def speed(law: Any, asked: float, force: float = 0.0) -> float:
    """At which the cylinder moves steadily [m/s]."""

    def unbalance(x: Any) -> list[float]:
        velocity, pressure_a, pressure_b = x[0], 1e5 * x[1], 1e5 * x[2]
        opening = OPENING_GAIN * command(law, asked, AREA_A * pressure_a - AREA_B * pressure_b)
        flows = EDGES.port_flows(opening, Pressures(SUPPLY, 0.0), pressure_a, pressure_b)
        held = AREA_A * pressure_a - AREA_B * pressure_b - force
        return [1e4 * (flows.a - AREA_A * velocity), 1e4 * (flows.b - AREA_B * velocity), 1e-4 * held]

    found = root(unbalance, [math.copysign(0.01, asked), 30.0, 60.0], tol=1e-13)
    assert max(map(abs, unbalance(found.x))) < 1e-9
    return float(found.x[0])


def test_a_valve_alone_retracts_slower_by_the_root_of_the_ratio() -> None:
    extend, retract = speed(BARE, 2.0), -speed(BARE, -2.0)
    assert retract / extend == pytest.approx(math.sqrt(RATIO), rel=1e-6)
    law = DirectionalGain(BARE, extend_gain=1.0, retract_gain=1.0 / math.sqrt(RATIO))
    assert -speed(law, -2.0) == pytest.approx(speed(law, 2.0), rel=1e-6)


@pytest.mark.parametrize("force", [-5e3, 0.0, 10e3])
def test_compensated_it_moves_alike_both_ways_under_any_load(force: float) -> None:
    expected = EDGES.port_flows(2.0 * OPENING_GAIN, Pressures(DROP, 0.0), 0.0, 0.0).a / AREA_A
    for asked in (2.0, -2.0):
        assert speed(COMPENSATED, asked, force) == pytest.approx(math.copysign(expected, asked), rel=1e-6)
    assert abs(speed(BARE, 2.0, 10e3) / speed(BARE, -2.0, 10e3)) < 0.95 * speed(BARE, 2.0) / -speed(
        BARE, -2.0
    )


def test_the_gain_is_limited_where_little_drop_is_left() -> None:
    for force in (AREA_A * SUPPLY, 1.1 * AREA_A * SUPPLY):
        assert command(COMPENSATED, 1.0, force) == pytest.approx(math.sqrt(35.0))
        assert command(COMPENSATED, -1.0, -force) == pytest.approx(-math.sqrt(35.0))


def test_a_reading_beyond_all_numbers_leaves_a_gain() -> None:
    s = COMPENSATED.init()
    for force in (0.0, -math.inf, 0.0, math.nan, 0.0):
        y = Measurement(0.0, force, 0.0, s.u, 0.0, 0.0, 0.0)
        s = COMPENSATED.step(s, y, Demand(1.0, 0.0, 0.0), 1e-3)
        assert s.gain > 0.0


def test_the_hydraulic_force_goes_through_the_low_pass() -> None:
    law = COMPENSATED._replace(time_constant=0.05, area_b=AREA_A, rated_drop=0.5 * SUPPLY)
    y = [Measurement(0.0, share * AREA_A * SUPPLY, 0.0, 0.0, 0.0, 0.0, 0.0) for share in (0.0, 0.5)]
    s = law.step(law.init(), y[0], Demand(2.0, 0.0, 0.0), 1e-5)
    assert s.u == 2.0
    for _ in range(5000):
        s = law.step(s, y[1], Demand(2.0, 0.0, 0.0), 1e-5)
    slow = 0.5 * (1.0 - math.exp(-1.0))
    assert s.u == pytest.approx(2.0 / math.sqrt(1.0 - slow), rel=1e-4)


def test_a_floor_above_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"least_drop.*must be below supply_pressure"):
        checked(COMPENSATED._replace(least_drop=SUPPLY))
