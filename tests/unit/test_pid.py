"""PID: feedforward, derivative, the integrator's range and limit, back-calculation."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import ParameterError
from hydroservo.control.controlled import Position, Velocity
from hydroservo.control.controllers import PI, PID, PIDState, Saturation
from hydroservo.control.observers import FilteredDerivative
from hydroservo.core.block import field_at
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.validation import checked
from hydroservo.scenario import load_scenario
from tests.support.bases import on_base

H = 1e-3
GAIN = 0.05  # [m/(s V)] of an axis that is an integrator
SPEED = 0.2  # [m/s]
signals = st.lists(st.tuples(*[st.floats(-5.0, 5.0)] * 3), min_size=1, max_size=20)


def at(position: float, command: float = 0.0, velocity: float = 0.0) -> Measurement:
    return Measurement(velocity, 0.0, position, command, 0.0, 0.0, 0.0)


def error_after(law: PID, rate: float, second_rate: float, seconds: float = 4.0) -> float:
    """The position error of an integrating axis that follows r = rate t + second_rate t^2/2."""
    s, position = law.init(), 0.0
    for k in range(round(seconds / H)):
        t = k * H
        r = Demand(rate * t + 0.5 * second_rate * t * t, rate + second_rate * t, second_rate)
        s = law.step(s, at(position, s.u), r, H)
        error = r.value - position
        position += GAIN * s.u * H
    return error


@given(signals)
def test_without_its_parts_it_gives_the_bits_of_pi(given_out: list[tuple[float, float, float]]) -> None:
    one = PI(3.0, 40.0, anti_windup=7.0, controls=Velocity())
    other = PID(3.0, 40.0, anti_windup=7.0, integral_limit=1e9, controls=Velocity())
    s, t = one.init(), other.init()
    for velocity, command, demand in given_out:
        y, r = at(0.0, command, velocity), Demand(demand, 1.0, 2.0)
        s, t = one.step(s, y, r, H), other.step(t, y, r, H)
        assert tuple(s) == tuple(t)[:3]


def test_a_ramp_leaves_the_velocity_over_the_loop_s_gain_and_none_with_feedforward() -> None:
    law = PID(80.0, controls=Position())
    assert error_after(law, SPEED, 0.0) == pytest.approx(SPEED / (GAIN * 80.0), rel=1e-6)
    assert error_after(law._replace(rate_feedforward=1.0 / GAIN), SPEED, 0.0) == pytest.approx(0.0, abs=1e-12)


def test_with_a_derivative_the_feedforward_that_leaves_no_error_of_a_ramp_is_larger_by_its_gain() -> None:
    """k_p e = (1/K_v + k_d - k_1) r'."""
    law = PID(80.0, derivative_gain=5.0, rate_feedforward=1.0 / GAIN, controls=Position())
    found = error_after(law, SPEED, 0.0, seconds=8.0)  # 26 time constants (1/K_v + k_d)/k_p
    assert found == pytest.approx(5.0 * SPEED / 80.0, rel=1e-6)  # 12.5 mm
    whole = law._replace(rate_feedforward=1.0 / GAIN + 5.0)
    assert error_after(whole, SPEED, 0.0, seconds=8.0) == pytest.approx(0.0, abs=1e-12)


def test_feedforward_is_of_the_demand_and_both_its_rates() -> None:
    law = PID(0.0, feedforward=2.0, rate_feedforward=0.3, second_rate_feedforward=-0.01, controls=Position())
    u = law.step(law.init(), at(0.0), Demand(1.0, 10.0, 100.0), H).u
    assert u == pytest.approx(2.0 + 3.0 - 1.0)


def test_the_derivative_is_of_what_is_measured_and_not_of_the_demand() -> None:
    law = PID(0.0, derivative_gain=0.5, derivative=FilteredDerivative(2e-3), controls=Position())
    s = law.step(law.init(), at(0.0), Demand(0.0, 0.0, 0.0), H)
    assert law.step(s, at(0.0), Demand(1.0, 1e3, 0.0), H).u == 0.0
    for k in range(1, 100):
        s = law.step(s, at(SPEED * k * H), Demand(0.0, 0.0, 0.0), H)
    assert s.u == pytest.approx(-0.5 * SPEED)


@pytest.mark.parametrize(("error", "integrates"), [(0.5, False), (1.0, True), (3.0, True), (3.5, False)])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_errors_in_range_are_integrated(error: float, integrates: bool, sign: float) -> None:
    law = PID(0.0, 10.0, integral_range=3.0, dead_zone=1.0, controls=Position())
    s = law.step(PIDState(0.0, 0.25, 0.0, law.derivative.init()), at(0.0), Demand(sign * error, 0.0, 0.0), H)
    assert s.integral == pytest.approx(0.25 + (sign * error * 10.0 * H if integrates else 0.0))


def test_a_position_in_the_dead_zone_leaves_the_command_at_rest() -> None:
    """What makes an axis with stiction hunt: an integral that grows on what is left of the error."""
    law = PID(1.0, 50.0, dead_zone=1e-4, controls=Position())
    s = law.init()
    for _ in range(1000):
        s = law.step(s, at(0.0, s.u), Demand(0.9e-4, 0.0, 0.0), H)
    assert s.integral == 0.0
    assert s.u == 0.9e-4


def test_the_integral_stays_in_its_limit() -> None:
    law = PID(0.0, 1e3, integral_limit=0.5, controls=Position())
    s = law.init()
    for demand, integral in ((1.0, 0.5), (-1.0, -0.5)):
        for _ in range(10):
            s = law.step(s, at(0.0, s.u), Demand(demand, 0.0, 0.0), H)
        assert s.integral == integral


def test_back_calculation_settles_at_the_limit_and_the_error_it_trades_for_it() -> None:
    """k_i e + k_aw (u_max - u_unlimited) = 0."""
    law = PID(
        1.0, 20.0, anti_windup=100.0, integral_limit=100.0, saturation=Saturation(2.0), controls=Position()
    )
    s = law.init()
    for _ in range(1000):
        s = law.step(s, at(0.0, s.u), Demand(3.0, 0.0, 0.0), H)
    assert s.u == 2.0
    assert s.unlimited == pytest.approx(2.0 + 20.0 * 3.0 / 100.0, rel=1e-9)


def test_a_range_that_is_left_open_is_automatic() -> None:
    """It stays a finite number, as a parameter of an FMU must be."""
    law = checked(PID(1.0, integral_range="auto"))  # type: ignore[arg-type]
    assert law == PID(1.0)
    assert np.isfinite(law.integral_range)


def test_a_dead_zone_beyond_the_range_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"dead_zone.*must be below integral_range, 0.001"):
        checked(PID(1.0, dead_zone=2e-3, integral_range=1e-3))


def test_an_acceleration_feedforward_takes_the_lag_s_error_away() -> None:
    """Of a constant acceleration on an axis K_v/(s (T s + 1)), whose command is (v + T a)/K_v."""
    lag, asked, errors = 0.05, 0.1, []
    for second in (0.0, lag / GAIN):
        law = PID(80.0, rate_feedforward=1.0 / GAIN, second_rate_feedforward=second, controls=Position())
        s, position, velocity = law.init(), 0.0, 0.0
        for t in np.arange(0.0, 3.0, H):
            s = law.step(s, at(position, s.u), Demand(0.5 * asked * t * t, asked * t, asked), H)
            errors.append(0.5 * asked * t * t - position)
            goal = GAIN * s.u
            share = -np.expm1(-H / lag)
            position += goal * H + (velocity - goal) * lag * share
            velocity += (goal - velocity) * share
    without, with_it = errors[len(errors) // 2 - 1], errors[-1]
    assert without == pytest.approx(asked * (lag + 0.5 * H) / (GAIN * 80.0), rel=1e-3)
    assert with_it == pytest.approx(asked * 0.5 * H / (GAIN * 80.0), rel=1e-3)


def test_in_a_position_loop_its_numbers_are_of_positions(tmp_path: Path) -> None:
    path = tmp_path / "position.toml"
    law = (
        'type = "PID"\nproportional_gain = "0.4 V/mm"\nrate_feedforward = "25 V s/m"\ndead_zone = "0.1 mm"\n'
    )
    demand = '[reference]\ntype = "Step"\ninitial = 0\nfinal = "1 mm"\n'
    text = f'[controls]\ntype = "Position"\n{demand}[controller]\n{law}'
    path.write_text(on_base(text), encoding="utf-8")
    loop = load_scenario(path)
    found = loop.controller
    assert (found.proportional_gain, found.rate_feedforward) == pytest.approx((400.0, 25.0))
    assert (found.dead_zone, found.integral_gain) == pytest.approx((1e-4, 0.0))
    units = {name: field_at(loop, f"controller.{name}").unit for name in PID._fields[:8]}
    assert list(units.values()) == ["V/m", "V/(m s)", "V s/m", "V/m", "V s/m", "V s^2/m", "V", "m"]
