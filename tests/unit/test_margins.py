"""Margins: closed forms, an independent root finder, loops at their very limit, and what has none."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hydroservo import Loop, ParameterError, linear, replace
from hydroservo.control.controlled import Command
from hydroservo.control.controllers import (
    DAC,
    PI,
    AntiWindup,
    Delay,
    FirstOrderADRC,
    HInfinityLoopShaping,
    Inverting,
    OpenLoop,
    RateLimit,
    Saturation,
)
from hydroservo.control.holds import DelayedHold
from hydroservo.control.wiring import believed
from hydroservo.core.block import is_block
from hydroservo.core.field import declared_fields
from hydroservo.linear import Margins, margins
from hydroservo.linear.margins import opened_loop_margins
from hydroservo.linear.operating_point import OperatingPoint, digital_sample, operating_point
from hydroservo.linear.system import OpenedLoop as Opened
from hydroservo.linear.system import opened_variants
from hydroservo.machine.loads import Constant
from hydroservo.machine.starts import Steady
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example
from tests.support.tiers import mostly


def rig(**changes: object) -> Loop:
    return replace(load_scenario("rig/1khz-pi-sine"), changes)


def integrator(gain: float, period: float) -> Opened:
    """L = k h/(z - 1), of a held integrator."""
    return Opened(np.ones((1, 1)), np.array([gain * period]), -np.ones(1), period)


@pytest.mark.parametrize(("gain", "period"), [(50.0, 1e-3), (900.0, 1e-3), (1.0, 1e-5)])
def test_a_loop_of_first_order_has_closed_forms(gain: float, period: float) -> None:
    """|k h/(z - 1)| = k h/(2 sin(w h/2)), its phase -pi/2 - w h/2, and k = 2/h is the limit."""
    found = opened_loop_margins(integrator(gain, period))
    crossover = 2.0 / period * math.asin(0.5 * gain * period)
    phase = 0.5 * math.pi - 0.5 * crossover * period
    assert found.stable
    assert found.gain_crossovers == pytest.approx((crossover,), rel=1e-9)
    assert found.phase_margin == pytest.approx(phase, rel=1e-9)
    assert found.delay_margin == pytest.approx(phase / crossover, rel=1e-9)
    assert found.gain_margin == pytest.approx(2.0 / (gain * period), rel=1e-9)
    assert found.gain_reduction_margin == 0.0
    assert found.phase_crossovers == pytest.approx((math.pi / period,))
    assert found.sensitivity_peak == pytest.approx(max(1.0, 1.0 / (1.0 - 0.5 * gain * period)), rel=1e-6)


def test_an_undamped_pole_is_no_phase_crossover() -> None:
    """At L = k (z - cos a)/(z^2 - 2 z cos a + 1) and z = e^(j a) the phase jumps, and |L| is infinite."""
    for angle in np.linspace(0.01, 1.0, 30):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        found = opened_loop_margins(Opened(turn, np.array([0.01, 0.0]), -np.array([1.0, 0.0]), 1e-3))
        assert found.stable
        assert found.gain_reduction_margin == 0.0
        assert min(abs(w - angle / 1e-3) for w in found.phase_crossovers) > 1.0


def test_the_disk_of_a_loop_of_first_order() -> None:
    """S - T = (1 - L)/(1 + L) is largest at Nyquist's frequency, where L = -k h/2."""
    found = opened_loop_margins(integrator(900.0, 1e-3))
    assert found.disk_margin == pytest.approx(2.0 * (1.0 - 0.45) / (1.0 + 0.45), rel=1e-6)


def test_a_loop_that_is_unstable_has_no_margins() -> None:
    found = opened_loop_margins(integrator(2100.0, 1e-3))
    assert not found.stable
    assert all(math.isnan(one) for one in found[1:7])


def test_a_loop_that_needs_its_gain_has_a_margin_below_one() -> None:
    """L = k h/(z - 1.01): stable for 0.01 < k h < 2.01."""
    found = opened_loop_margins(Opened(np.array([[1.01]]), np.array([0.05]), -np.ones(1), 1e-3))
    assert found.gain_reduction_margin == pytest.approx(0.2, rel=1e-6)
    assert found.gain_margin == pytest.approx(2.01 / 0.05, rel=1e-9)


def exactly_sampled(loop: Loop, k_p: float, k_i: float) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator in z of a PI law around the design model behind its valve, at rest."""
    m, h, tau = believed(loop), loop.simulation.period, loop.valve.time_constant
    a = np.array(
        [[m.f1(1.0), m.g1(), 0.0], [m.f2(1.0, 0.0), m.f2(0.0, 1.0), m.g2(0.0, 0.0)], [0.0, 0.0, -1.0 / tau]]
    )
    both = expm(np.vstack([np.column_stack([a, [0.0, 0.0, 1.0 / tau]]), np.zeros(4)]) * h)
    moved, driven = both[:3, :3], both[:3, 3]
    low = np.poly(moved)
    top = np.poly(moved - np.outer(driven, [1.0, 0.0, 0.0])) - low
    return np.polymul(top, [k_p + h * k_i, -k_p]), np.polymul(low, [1.0, -1.0])


@pytest.mark.parametrize(("k_p", "k_i"), [(1.0, 100.0), (3.0, 600.0), (3.2309, 619.14)])
def test_a_pi_law_around_the_design_model(k_p: float, k_i: float) -> None:
    """Against the roots on the unit circle of |L| = 1 and of Im L = 0, by polynomials in z."""
    loop = rig(controller=PI(k_p, k_i))
    top, low = exactly_sampled(loop, k_p, k_i)
    h = loop.simulation.period
    top = np.append(np.zeros(len(low) - len(top)), top)

    def at(z: complex) -> complex:
        return np.polyval(top, z) / np.polyval(low, z)

    def on_circle(polynomial: np.ndarray) -> list[complex]:
        return [z for z in np.roots(polynomial) if abs(abs(z) - 1.0) < 1e-6 and z.imag > 1e-6]

    gains = on_circle(np.polysub(np.polymul(top, top[::-1]), np.polymul(low, low[::-1])))
    phases = on_circle(np.polysub(np.polymul(top, low[::-1]), np.polymul(low, top[::-1])))
    phases = [z for z in phases if at(z).real < 0.0]
    found = margins(loop)
    assert found.stable
    assert found.gain_crossovers == pytest.approx(sorted(np.angle(gains) / h), rel=1e-6)
    assert found.phase_crossovers == pytest.approx(sorted(np.angle(phases) / h), rel=1e-6)
    assert found.gain_margin == pytest.approx(min(1.0 / abs(at(z)) for z in phases), rel=1e-6)
    assert found.phase_margin == pytest.approx(min(math.pi + np.angle(at(z)) for z in gains), rel=1e-6)
    w = np.linspace(1.0, math.pi / h, 100_001)
    s = 1.0 / (1.0 + at(np.exp(1j * w * h)))
    assert found.sensitivity_peak == pytest.approx(np.abs(s).max(), rel=1e-6)
    assert found.disk_margin == pytest.approx(2.0 / np.abs(2.0 * s - 1.0).max(), rel=1e-6)


def test_what_another_library_gives() -> None:
    """stability_margins and disk_margins of python-control 0.10.2, for the model of the last test."""
    found = margins(rig(controller=PI(3.0, 600.0)))
    assert found.disk_margin == pytest.approx(0.6015268, rel=1e-6)


LAWS = {
    "PI": PI(3.0, 600.0),
    "windup": PI(3.0, 600.0, 200.0),
    "H-infinity": HInfinityLoopShaping(10.0, 3000.0, 0.01),
    "ADRC": FirstOrderADRC(103.0, bandwidth=50.0, observer_bandwidth=200.0),
    "rate limit": RateLimit(PI(3.0, 600.0), rate=1e4),
    "anti-windup": AntiWindup(PI(3.0, 600.0, saturation=Saturation(100.0)), gain=3.0),
    "inverting": example(Inverting),
    "delay": Delay(PI(1.0, 100.0)),
}


@pytest.mark.slow  # many loops in plain Python
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LAWS, [*LAWS][:1]))
@pytest.mark.parametrize("delay", [0.0, 4e-4])
@pytest.mark.parametrize("command", [0.0, 0.05])
def test_closed_it_moves_as_the_loop_does(name: str, delay: float, command: float) -> None:
    """What the law asks for after one command that is a little off, as the loop's own blocks have it."""
    loop = rig(controller=LAWS[name])
    if delay:
        loop = replace(loop, {"hold": DelayedHold(delay)})
    point = operating_point(loop, command)
    nudge = 1e-5
    theirs = (after_a_nudge(point, nudge) - after_a_nudge(point, -nudge)) / (2.0 * nudge)
    found = opened_variants(point).loop
    ours, x = [], found.b
    for _ in theirs:
        ours.append(found.c @ x)
        x = found.closed() @ x
    sure = 1e-4 + 3.0 * margins(loop, command=command).error  # the integrator's steps, and the slopes
    assert np.abs(theirs - ours).max() < sure * np.abs(ours).max()


def after_a_nudge(point: OperatingPoint, nudge: float) -> np.ndarray:
    """The commands that follow one which reaches the machine with something added [V]."""
    loop, h = point.loop._replace(load=Constant(point.force)), point.loop.simulation.period
    machine, digital, hold, last, commands = (
        point.machine,
        point.digital,
        point.digital.hold,
        point.command,
        [],
    )
    for k in range(60):
        digital = digital_sample(point, machine, digital, point.demand)
        u = digital.controller.u
        commands.append(u)
        given = u + (nudge if k == 0 else 0.0)
        hold = loop.hold.step(hold, last, 0.0)
        machine = loop.simulation.integrator.advance(loop, 0.0, machine, loop.hold.held(hold, given), h, 20)
        last = given
    return np.array(commands[1:])


@pytest.mark.parametrize("name", ["PI", "windup", "H-infinity"])
def test_the_gain_margin_is_where_the_loop_becomes_unstable(name: str) -> None:
    loop = rig(controller=LAWS[name])
    limit = margins(loop).gain_margin

    def stable(factor: float) -> bool:
        """With a valve that opens so much wider, which the law does not know."""
        wider = replace(loop, {"valve.gain": factor * loop.valve.gain})
        return margins(
            replace(wider, {"controller.model": believed(loop)}) if name == "H-infinity" else wider
        ).stable

    assert stable(0.999 * limit)
    assert not stable(1.001 * limit)


def test_the_delay_margin_is_what_a_late_command_takes_of_it() -> None:
    loop = rig()
    whole = margins(loop).delay_margin
    for delay in (2e-4, 1e-3):
        late = margins(replace(loop, {"hold": DelayedHold(delay)}))
        assert late.delay_margin == pytest.approx(whole - delay, rel=0.03)


def test_the_disk_lies_within_the_other_margins() -> None:
    for name in ("PI", "H-infinity", "ADRC"):
        found = margins(rig(controller=LAWS[name]))
        alpha = found.disk_margin
        assert (2.0 + alpha) / (2.0 - alpha) <= found.gain_margin
        assert 2.0 * math.atan(0.5 * alpha) <= found.phase_margin


def test_a_converter_counts_as_fine() -> None:
    bare, coarse = margins(rig(controller=LAWS["PI"])), margins(rig(controller=DAC(LAWS["PI"], bits=8)))
    assert coarse.gain_margin == pytest.approx(bare.gain_margin, rel=1e-6)
    assert margins(load_scenario("rig/encoder-pi-sine")).stable


def test_the_operating_point_of_a_law_that_leaves_an_error() -> None:
    """A P law asks for a command by an error of u/k_p, at the velocity that the command gives."""
    point = operating_point(rig(controller=PI(2.0)), 0.05)
    assert point.demand.value - point.machine.plant.velocity == pytest.approx(0.05 / 2.0, rel=1e-6)
    assert point.digital.controller.u == pytest.approx(0.05, rel=1e-6)


def test_sensors_that_difference_a_moving_position_see_its_velocity() -> None:
    point = operating_point(load_scenario("rig/encoder-pi-sine"), 0.05)
    velocity = point.machine.plant.velocity
    assert velocity > 0.02
    assert point.digital.sensors.velocity.value == pytest.approx(velocity, rel=1e-6)
    assert point.demand.value == pytest.approx(velocity, rel=1e-6)


def test_a_steady_start_says_the_command() -> None:
    loop = rig(start=Steady(0.05))
    assert margins(loop) == margins(rig(), command=0.05)
    assert margins(rig(), command=1) == margins(rig(), command=1.0)
    assert margins(loop) != margins(rig())


def test_the_record_is_immutable_and_has_units() -> None:
    found = margins(rig())
    with pytest.raises(AttributeError):
        found.gain_margin = 3.0  # type: ignore[misc]
    fields = declared_fields(Margins)
    assert set(fields) == set(Margins._fields)
    assert (fields["phase_margin"].unit, fields["delay_margin"].unit) == ("rad", "s")
    assert fields["gain_crossovers"].unit == "rad/s"
    assert is_block(found)
    assert linear.margins is margins


def test_a_pole_on_the_unit_circle_is_no_crossing() -> None:
    found = margins(load_scenario("laws/internal-model-sine"))  # resonates at the 0.25 Hz of its demand
    assert all(w > min(found.gain_crossovers) for w in found.phase_crossovers)
    assert found.gain_reduction_margin == 0.0


@pytest.mark.parametrize(
    ("loop", "command", "said"),
    [
        (lambda: load_scenario("paper/sine-tsmc"), None, "controller = 'TSMC': is not linear about"),
        (lambda: load_scenario("axis/position"), None, "plant = 'Cylinder': is not linear about"),
        (
            lambda: load_scenario("axis/crane"),
            None,
            "closes no loop here: small changes of the command do not",
        ),
        (
            lambda: rig(controller=PI(3.0, 0.0, saturation=Saturation(0.01))),
            0.05,
            "has no operating point under 0.05 V",
        ),
        (lambda: rig(controls=Command(), controller=OpenLoop()), None, "closes no loop here"),
        (lambda: "rig/1khz-pi-sine", None, "must be a Loop"),
        (rig, "much", "start.command = 'much': must be a finite number [V]"),
    ],
)
def test_what_has_no_margins_says_so_in_one_line(loop, command, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError) as caught:
        margins(loop(), command=command)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
