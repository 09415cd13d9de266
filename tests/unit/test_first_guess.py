"""A first guess of gains against closed forms, and against the margins of the loops that it makes."""

import math
from collections.abc import Mapping

import pytest

from hydroservo import Loop, load_scenario, replace
from hydroservo.control.controlled import Force, Position
from hydroservo.control.controllers import PI, PID, Cascade, DirectionalGain, InvertedPolarity, OpenLoop
from hydroservo.control.references import Sine
from hydroservo.core.errors import ParameterError
from hydroservo.linear.first_guess import FirstGuess, HydraulicAxis, feedforward_of, first_guess, stable_gain
from hydroservo.linear.moving_margins import SHARES, largest_command, points_in_motion
from hydroservo.machine.theory import damping_ratio, natural_frequency

OF_A_RUN = {"simulation.duration": 0.2, "simulation.period": 1e-5}


def guess_of(loop: Loop) -> FirstGuess:
    found = first_guess(loop)
    assert found is not None
    return found


def least_margins(loop: Loop, changes: Mapping[str, float]) -> tuple[float, float]:
    """The least gain margin [dB] and phase margin [deg] of a loop with other gains, where it is guessed."""
    largest = largest_command(loop)
    least = min(map(abs, SHARES)) * largest
    every = points_in_motion(replace(loop, changes), largest)
    found = [at.margins for point, at in every if abs(point.command) >= least]
    assert found
    assert all(one.stable for one in found)
    gain, phase = min(one.gain_margin for one in found), min(one.phase_margin for one in found)
    return 20.0 * math.log10(gain), math.degrees(phase)


@pytest.fixture(scope="module")
def machine() -> Loop:
    """The paper's, of closed form: its valve has no lag, its friction is viscous; here 10 % damped."""
    loop = replace(load_scenario("paper/sine-pi"), OF_A_RUN)
    plant = loop.plant._replace(damping=0.2 * loop.plant.damping, leakage=0.2 * loop.plant.leakage)
    return loop._replace(plant=plant, controller=PI(0.0, 10.0))


@pytest.fixture(scope="module")
def position(machine: Loop) -> Loop:
    return machine._replace(
        controls=Position(),
        controller=PID(10.0),
        reference=Sine(1e-4, 5.0, offset=machine.plant.start_position),
    )


def test_omega_zeta_and_velocity_gain_are_those_of_textbooks(machine: Loop) -> None:
    found, plant, orifice = guess_of(machine), machine.plant, machine.valve.orifice
    flow = orifice.discharge_coefficient * orifice.area_gradient * machine.valve.gain
    flow *= math.sqrt(machine.supply.supply_pressure / orifice.density)  # per volt
    assert found.natural_frequency == pytest.approx(natural_frequency(plant), rel=1e-3)
    assert found.damping_ratio == pytest.approx(damping_ratio(plant), rel=0.01)
    assert found.velocity_gain == pytest.approx(flow / plant.piston_area, rel=1e-3)


def test_a_position_law_is_left_six_decibels(position: Loop) -> None:
    found = guess_of(position)
    gain = found.damping_ratio * found.natural_frequency / found.velocity_gain
    p, i, ahead = found.parameters.values()
    assert list(found.parameters) == [
        f"controller.{name}" for name in ("proportional_gain", "integral_gain", "rate_feedforward")
    ]
    assert list(found.rules) == list(found.parameters)
    assert p == pytest.approx(gain, rel=0.01)
    assert i == pytest.approx(p * p * found.velocity_gain / 10.0)
    assert ahead == pytest.approx(1.0 / found.velocity_gain, rel=1e-3)
    for gains in ({"controller.proportional_gain": p}, found.parameters):
        assert least_margins(position, gains)[0] == pytest.approx(6.0, abs=0.3)


def test_a_velocity_law_is_left_six_decibels(machine: Loop) -> None:
    found = guess_of(machine)
    p, i = (found.parameters[f"controller.{name}"] for name in ("proportional_gain", "integral_gain"))
    assert i == pytest.approx(found.damping_ratio * found.natural_frequency / found.velocity_gain, rel=0.01)
    assert i / p == pytest.approx(4.0 * found.natural_frequency)
    assert least_margins(machine, found.parameters)[0] == pytest.approx(6.0, abs=1.0)


@pytest.mark.parametrize(
    "scenario", ["axis/crane", "axis/pump-controlled", "cases/encoder", "rig/1khz-pi-sine"]
)
def test_lags_of_valve_hold_and_sensors_leave_as_much(scenario: str) -> None:
    loop = load_scenario(scenario)
    gain, phase = least_margins(loop, guess_of(loop).parameters)
    assert gain > 6.0
    assert phase > 40.0


def test_a_lag_lowers_the_stable_gain_by_its_phase() -> None:
    pole = complex(-50.0, 50.0 * math.sqrt(3.0))  # omega = 100 rad/s, zeta = 0.5
    assert stable_gain(pole, lambda _: 0.0) == pytest.approx(100.0)
    x = 0.5 * (math.sqrt(5.0) - 1.0)  # where 1 - x^2 = 2 zeta x, and the axis lags by 45 degrees
    wanted = 100.0 * x * math.hypot(1.0 - x * x, x)
    assert stable_gain(pole, lambda _: 0.25 * math.pi) == pytest.approx(wanted)


def test_a_light_axis_keeps_its_resonance_below_one_whatever_lags() -> None:
    assert stable_gain(complex(-1.0, 100.0), lambda _: 0.25 * math.pi) == pytest.approx(2.0)


def test_what_wraps_a_law_counts_in_its_velocity_gain(position: Loop) -> None:
    alone = guess_of(position)
    doubled = DirectionalGain(position.controller, 2.0, 2.0)
    found = guess_of(position._replace(controller=InvertedPolarity(InvertedPolarity(doubled))))
    path = "controller.controller.controller.controller.proportional_gain"
    assert found.velocity_gain == pytest.approx(2.0 * alone.velocity_gain, rel=1e-3)
    assert found.parameters[path] == pytest.approx(
        0.5 * alone.parameters["controller.proportional_gain"], rel=1e-3
    )


def test_a_cascade_is_slower_than_its_velocity_law(position: Loop) -> None:
    loop = position._replace(controller=Cascade(PI(1.0, 100.0), 10.0, max_velocity=0.5))
    found = guess_of(loop)
    inner = found.parameters["controller.controller.integral_gain"] * found.velocity_gain
    assert found.parameters["controller.proportional_gain"] == pytest.approx(0.25 * inner)
    assert found.parameters["controller.rate_feedforward"] == 1.0
    assert least_margins(loop, found.parameters)[0] == pytest.approx(6.0, abs=1.5)


def test_a_feedforward_has_what_an_overlap_takes() -> None:
    ways = [
        HydraulicAxis(100.0, 0.1, 0.1, 20.0, 0.1 * (u - math.copysign(0.5, u)), u)
        for u in (-2.0, -1.0, 1.0, 2.0)
    ]
    assert feedforward_of(ways) == pytest.approx(2.0 / 0.15)
    assert feedforward_of(ways[:1]) == pytest.approx(10.0)


def test_a_derivative_that_stays_is_made_up_for(position: Loop) -> None:
    damped = guess_of(replace(position, {"controller.derivative_gain": 0.05}))
    ahead = damped.parameters["controller.rate_feedforward"]
    assert ahead > 1.0 / damped.velocity_gain
    assert ahead - 0.05 == pytest.approx(
        guess_of(position).parameters["controller.rate_feedforward"], rel=1e-2
    )


def test_there_is_none_without_a_rule_or_an_oscillation(machine: Loop, position: Loop) -> None:
    assert first_guess(machine._replace(controls=Force())) is None
    assert first_guess(machine._replace(controller=OpenLoop())) is None
    assert first_guess(load_scenario("paper/sine-tsmc")) is None
    assert first_guess(replace(position, {"plant.damping": 2000.0 * position.plant.damping})) is None
    assert first_guess(position._replace(controller=PID(0.0))) is None  # which does not move it
    with pytest.raises(ParameterError, match="must be a Loop"):
        first_guess("axis/position")  # type: ignore[arg-type]
