"""The second-order spool: its response, its limits and its hysteresis."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hydroservo import ParameterError
from hydroservo.machine.valves import SecondOrderValve, SecondOrderValveState
from hydroservo.papers.tsmc_eha_2021.machine import ORIFICE
from hydroservo.testing.examples import example


def response(valve: SecondOrderValve, frequency: float) -> complex:
    """x(j w)/(K u) from the equation of motion linearised at rest."""
    small = 1e-3 * valve.max_opening
    columns = [
        valve.deriv(SecondOrderValveState(small, 0.0), 0.0),
        valve.deriv(valve.init()._replace(speed=small), 0.0),
    ]
    a = np.array(columns).T / small
    b = np.array(valve.deriv(valve.init(), small / valve.gain)) / small
    return complex(np.linalg.solve(2j * math.pi * frequency * np.eye(2) - a, b)[0])


def moved(
    valve: SecondOrderValve,
    command: Callable[[float], float],
    duration: float,
    start: tuple[float, float] = (0.0, 0.0),
) -> np.ndarray:
    """Rows t, x and v of the spool under a command."""
    found = solve_ivp(
        lambda t, y: valve.deriv(SecondOrderValveState(*y), command(t)),
        (0.0, duration),
        start,
        rtol=1e-9,
        atol=1e-14,
        max_step=0.05 / valve.natural_frequency,
    )
    assert found.success
    return np.vstack([found.t, found.y])


@pytest.mark.parametrize("frequency", [1.0, 20.0, 47.0, 100.0, 500.0])
@pytest.mark.parametrize("damping", [0.4, 1.0, 3.0])
def test_small_signals_see_the_linear_system(frequency: float, damping: float) -> None:
    wn = 2.0 * math.pi * 47.0
    ratio = frequency / 47.0
    wanted = 1.0 / complex(1.0 - ratio * ratio, 2.0 * damping * ratio)
    valve = example(SecondOrderValve, natural_frequency=wn, damping_ratio=damping)
    assert response(valve, frequency) == pytest.approx(wanted, rel=1e-11)


@pytest.mark.parametrize(("f90", "f3"), [(100.0, 100.0), (60.0, 25.0), (80.0, 120.0), (50.0, 1.0)])
def test_a_datasheet_s_frequencies_come_out(f90: float, f3: float) -> None:
    valve = SecondOrderValve.from_response(f90, f3, 1e-4, 5e-3, ORIFICE, slew_limit=1.0)
    assert math.degrees(np.angle(response(valve, f90))) == pytest.approx(-90.0, abs=1e-9)
    assert abs(response(valve, f3)) == pytest.approx(math.sqrt(0.5), rel=1e-11)
    assert (valve.gain, valve.slew_limit) == (1e-4, 1.0)


def test_equal_frequencies_mean_the_damping_of_a_butterworth_filter() -> None:
    assert SecondOrderValve.from_response(
        70.0, 70.0, 5e-4, 5e-3, ORIFICE, slew_limit=0.5
    ).damping_ratio == pytest.approx(math.sqrt(0.5), rel=1e-15)


@pytest.mark.parametrize(("f90", "f3"), [(100.0, 155.4), (1.0, 1e300), (1e-300, 1e300), (1e300, 1e-300)])
def test_frequencies_of_no_damping_are_refused(f90: float, f3: float) -> None:
    with pytest.raises(ParameterError, match=r"frequency_3db = .*: must be below 1\.55 times frequency_90"):
        SecondOrderValve.from_response(f90, f3, 5e-4, 5e-3, ORIFICE, slew_limit=0.5)


def test_a_sine_is_followed_with_the_amplitude_of_the_formula() -> None:
    valve = example(SecondOrderValve, natural_frequency=300.0, damping_ratio=0.3)
    w, cycles, u = 240.0, 40, 0.1
    t, x, _ = moved(valve, lambda t: u * math.sin(w * t), cycles * 2.0 * math.pi / w)
    late = t > (cycles - 5) * 2.0 * math.pi / w
    basis = np.column_stack([np.sin(w * t[late]), np.cos(w * t[late])])
    found = np.linalg.lstsq(basis, x[late] / (valve.gain * u), rcond=None)[0]
    wanted = 1.0 / complex(1.0 - 0.64, 2.0 * 0.3 * 0.8)
    assert found == pytest.approx([wanted.real, wanted.imag], abs=1e-5)


@pytest.mark.parametrize("damping", [0.2, 0.8, 1.5])
def test_a_large_step_goes_as_fast_as_the_slew_limit_and_no_faster(damping: float) -> None:
    valve = example(SecondOrderValve, natural_frequency=600.0, damping_ratio=damping, slew_limit=0.2)
    _, x, v = moved(valve, lambda _: 10.0, 0.08, start=(-5e-3, 0.0))
    assert v.max() == pytest.approx(valve.slew_limit, rel=1e-3)
    assert v.max() <= valve.slew_limit * (1.0 + 1e-9)
    assert x[-1] == pytest.approx(valve.max_opening, rel=1e-3)


def test_half_a_travel_at_the_slew_limit_takes_its_time() -> None:
    valve = example(SecondOrderValve, natural_frequency=3000.0, damping_ratio=0.8, slew_limit=0.1)
    t, x, _ = moved(valve, lambda _: 10.0, 0.06)
    first, last = (float(np.interp(share * 5e-3, x, t)) for share in (0.2, 0.8))
    assert last - first == pytest.approx(0.6 * 5e-3 / 0.1, rel=1e-3)


commands = st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=4)


@given(u=commands, damping=st.floats(0.05, 3.0), slew=st.floats(0.05, 10.0), hysteresis=st.floats(0.0, 1e-3))
def test_a_spool_never_passes_its_limits(
    u: list[float], damping: float, slew: float, hysteresis: float
) -> None:
    valve = example(SecondOrderValve, damping_ratio=damping, slew_limit=slew, hysteresis=hysteresis)
    x, v, h = 0.0, 0.0, 0.02 / valve.natural_frequency
    for command in u:
        for _ in range(200):  # Euler steps keep what the equation keeps, exactly, while 5 wn h < 1
            _, rate = valve.deriv(SecondOrderValveState(x, v), command)
            x, v = x + h * v, v + h * rate
            assert abs(x) <= valve.max_opening * (1.0 + 1e-12)
            assert abs(v) <= slew * (1.0 + 1e-12)


@given(u=st.floats(-100.0, 100.0), side=st.sampled_from([-1.0, 1.0]))
def test_at_its_limit_a_spool_has_no_outward_acceleration(u: float, side: float) -> None:
    valve = example(SecondOrderValve, damping_ratio=0.1)
    rate = valve.deriv(SecondOrderValveState(side * valve.max_opening, 0.0), u)
    assert rate.opening == 0.0
    assert side * rate.speed <= 0.0


def test_hysteresis_is_as_wide_as_its_parameter() -> None:
    """A slow triangle: the command at which the opening passes 0 differs between the two directions."""
    valve = example(SecondOrderValve, hysteresis=2e-4)
    period, peak = 20.0, 2.0

    def triangle(t: float) -> float:
        phase = t / period % 1.0
        return peak * (4.0 * abs(phase - 0.5) - 1.0)

    found = solve_ivp(
        lambda t, y: valve.deriv(SecondOrderValveState(*y), triangle(t)),
        (0.0, 1.5 * period),
        (0.0, 0.0),
        method="LSODA",
        rtol=1e-7,
        atol=1e-12,
        max_step=0.05,
    )
    t, x = found.t, found.y[0]
    falling, rising = (t > 0.1 * period) & (t < 0.45 * period), (t > 0.6 * period) & (t < 0.95 * period)
    down = triangle(float(np.interp(0.0, -x[falling], t[falling])))
    up = triangle(float(np.interp(0.0, x[rising], t[rising])))
    assert valve.gain * (up - down) == pytest.approx(valve.hysteresis, rel=2e-2)


def test_within_its_hysteresis_a_spool_stays() -> None:
    valve = example(SecondOrderValve, hysteresis=2e-4)
    rest = SecondOrderValveState(1e-3, 0.0)
    assert valve.deriv(rest, 1.09e-3 / valve.gain).speed == 0.0
    assert valve.deriv(rest, 1.11e-3 / valve.gain).speed > 0.0
    assert valve.opening(rest, 10.0) == 1e-3
