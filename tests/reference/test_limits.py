"""Limits against closed forms, least squares of a linear machine, and the laws that they are limits of."""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from hydroservo import Loop, limit, load_scenario, replace
from hydroservo.control.controlled import Position
from hydroservo.control.controllers import PI, Saturation
from hydroservo.control.controllers.rate_limit import RateLimit
from hydroservo.control.references import Sine, Step
from hydroservo.core.block import Field
from hydroservo.core.signals import MachineOutputs, PortFlows, Pressures
from hydroservo.limits.command import Playback, command_limits
from hydroservo.limits.least_error import machine_limits, without_law
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.loads import Constant
from hydroservo.machine.valves import StaticValve
from tests.support.tiers import mostly

PERIOD, SUBSTEPS = 1e-3, 4
QUICK = {"simulation.duration": 0.25, "reference.period": 0.3}  # of a square: it jumps at 0.15 s


class MoverState(NamedTuple):
    velocity: Annotated[float, Field("m/s", "velocity")]
    position: Annotated[float, Field("m", "position")]


class Mover(NamedTuple):
    """dv/dt = k u - b v - c x: a machine of which the best command is known."""

    gain: Annotated[float, Field("m/(s^2 V)", "k", "example")] = 1.0
    damping: Annotated[float, Field("1/s", "b", "example")] = 0.0
    stiffness: Annotated[float, Field("1/s^2", "c", "example")] = 0.0
    stroke: Annotated[float, Field("m", "stroke", "example")] = 1.0
    start_position: Annotated[float, Field("m", "position at the start", "example")] = 0.0

    def init(self) -> MoverState:
        return MoverState(0.0, self.start_position)

    def flows(self, s: MoverState, ports: Ports) -> PortFlows:
        return PortFlows(ports.feed.command, 0.0, 0.0, 0.0)

    def deriv(self, s: MoverState, flows: PortFlows, force: float) -> MoverState:
        pushed = self.gain * flows.a - self.damping * s.velocity - self.stiffness * s.position
        return MoverState(pushed, s.velocity)

    def hydraulic_force(self, s: MoverState) -> float:
        return 0.0 * s.velocity

    def outputs(self, s: MoverState, line: Pressures, force: float) -> MachineOutputs:
        return MachineOutputs(s.velocity, 0.0, s.position, 0.0, 0.0, force)


def moved(plant: Mover, reference: Any, duration: float, **changes: object) -> Loop:
    """A loop that moves a mover, with a limit of 1 V."""
    rig = load_scenario("rig/1khz-pi-square")
    edges = rig.valve.orifice
    simulation = rig.simulation._replace(duration=duration, period=PERIOD, substeps=SUBSTEPS)
    return rig._replace(
        simulation=simulation,
        plant=plant,
        valve=StaticValve(gain=1e-3, max_opening=5e-3, orifice=edges),
        reference=reference,
        load=Constant(0.0),
        controller=PI(1.0, 1.0, saturation=Saturation(1.0)),
    )._replace(**changes)


@pytest.mark.slow
def test_an_integrator_follows_a_step_along_the_steepest_ramp():
    """|dv/dt| <= 1: the error falls from A in n steps, whose squares sum to A^2 (n+1)(2n+1)/(6n)."""
    height, duration, n = 0.04, 0.2, 160
    found = limit(moved(Mover(), Step(0.0, height, 0.0), duration))
    h = PERIOD / SUBSTEPS
    expected = height * math.sqrt(h * (n + 1) * (2 * n + 1) / (6 * n) / duration)
    assert found.causal["rms_error"] == pytest.approx(expected, rel=1e-6)
    assert found.clairvoyant["rms_error"] == pytest.approx(expected, rel=1e-6)
    assert found.causal["controller.u"].values[:39] == pytest.approx(1.0, abs=1e-4)  # the barrier's


def test_to_know_of_a_step_halves_the_error_of_an_integrator():
    """Begun half the ramp's time T early the error is two triangles of A/2: A^2 T/12 in place of A^2 T/3."""
    height, duration = 0.04, 0.2
    found = limit(moved(Mover(), Step(0.0, height, 0.1), duration))
    late, early = (height * math.sqrt(0.04 / share / duration) for share in (3.0, 12.0))
    of_left_rule = 1.0 / 160  # half a step of 1/160 of the ramp, in the square
    assert found.causal["rms_error"] == pytest.approx(late, rel=of_left_rule)
    assert found.clairvoyant["rms_error"] == pytest.approx(early, rel=2.0 * of_left_rule)
    before = found.causal["controller.u"].values[:100]
    assert np.abs(before).max() < 1e-4  # of what it is afterwards


CURVE = math.sqrt((math.sqrt(33.0) - 1.0) / 24.0)  # Fuller's h: the command changes its sign at x = -h v |v|


def squares_of(curve: float, height: float) -> float:
    """The integral of x^2 of d2x/dt2 = -1 from (height, 0) to x = -h v |v|, where u is 1, and so on.

    The speeds at two switches one after the other have the ratio q = ((1 - 2h) / (1 + 2h))^1/2, and what is
    left after them the ratio q^5: dt is as v, and x^2 as v^4. On each arc x is a quadratic function of v.
    """
    speed = math.sqrt(height / (0.5 + curve))  # at the first switch
    ratio = math.sqrt((1.0 - 2.0 * curve) / (1.0 + 2.0 * curve))

    def arc(first: float, last: float, begun: float, bent: float) -> float:
        """Of x = begun + bent v^2 / 2 from one speed to another."""
        parts = [begun**2, 0.0, begun * bent, 0.0, bent**2 / 4.0]
        return sum(one * (last ** (i + 1) - first ** (i + 1)) / (i + 1) for i, one in enumerate(parts))

    falling = arc(0.0, speed, height, -1.0)
    stopping = arc(-speed, ratio * speed, -(0.5 - curve) * speed**2, 1.0)
    return falling + stopping / (1.0 - ratio**5)


def test_fullers_curve_is_the_best_of_its_kind():
    best = min(np.linspace(0.40, 0.49, 9001), key=lambda one: squares_of(float(one), 1.0))
    assert best == pytest.approx(CURVE, abs=2e-5)


def test_a_double_integrator_follows_a_step_as_fuller_found():
    """|d2x/dt2| <= 1, the integral of x^2 least: bang-bang, infinitely many switches in a finite time.

    A command that changes at samples alone does no better, and a switch that comes up to a sample late costs
    a share of the order of (period / time to the switch)^2. The sum of squares at the beginning of steps is
    more than the integral by half a step's first square.

    Source: Fuller, Study of an optimum non-linear control system, Journal of Electronics and Control 15,
    1963, 63-71; Liberzon, Calculus of Variations and Optimal Control Theory, 2012, section 4.5.
    """
    height, duration = 0.04, 0.8
    loop = moved(Mover(start_position=height), Step(0.0, 0.0, 0.0), duration)
    found = limit(loop._replace(controls=Position())).clairvoyant
    first_square = 0.5 * PERIOD / SUBSTEPS * height**2
    left = duration * float(found["rms_error"]) ** 2 - first_square
    least = squares_of(CURVE, height)
    assert least * (1.0 - 1e-6) < left < least * (1.0 + 1e-5)
    command = found["controller.u"].values
    switch = math.sqrt(height / (0.5 + CURVE)) / PERIOD  # samples
    second = switch * (1.0 + 1.0 + math.sqrt((1.0 - 2.0 * CURVE) / (1.0 + 2.0 * CURVE)))
    assert (command[: int(switch)] < -0.99).all()  # but for the barrier's share
    assert (command[math.ceil(switch) : int(second) - 1] > 0.99).all()


def test_a_command_of_limited_rate_is_followed_to_its_limit():
    """|du/dt| <= 10 V/s and du/dt = 0 in a period: u_k - u_(k-1) <= 10 mV."""
    loop = moved(Mover(), Step(0.0, 0.04, 0.0), 0.2)
    found = limit(loop._replace(controller=RateLimit(loop.controller, 10.0)))
    changes = np.diff(found.causal["controller.u"].values, prepend=0.0)
    assert np.abs(changes).max() == pytest.approx(10.0 * PERIOD, rel=1e-6)
    assert float(found.causal["rms_error"]) > float(limit(loop).causal["rms_error"])


@pytest.mark.slow
def test_of_a_linear_machine_the_limit_is_the_least_squares_solution():
    """Within its limits e is linear in all commands: numpy's least squares of the rows stacked by hand."""
    plant, duration = Mover(gain=30.0, damping=20.0, stiffness=1000.0), 0.08
    loop = moved(plant, Sine(amplitude=0.02, frequency=8.0), duration)
    found = limit(loop)
    samples, h = round(duration / PERIOD), PERIOD / SUBSTEPS
    a = np.array([[-20.0, -1000.0], [1.0, 0.0]])
    powers = [np.linalg.matrix_power(h * a, i) / math.factorial(i) for i in range(5)]
    step, held = sum(powers), h * sum(p / (i + 1) for i, p in enumerate(powers[:4])) @ np.array([30.0, 0.0])
    rows, of_commands, demands = [], np.zeros((2, samples)), []
    for i in range(samples * SUBSTEPS):
        rows.append(of_commands[0].copy())
        demands.append(loop.reference.at(i * h).value)
        of_commands = step @ of_commands
        of_commands[:, i // SUBSTEPS] += held
    best, *_ = np.linalg.lstsq(np.array(rows), np.array(demands), rcond=None)
    left = np.array(rows) @ best - np.array(demands)
    assert np.abs(best).max() < 1.0
    assert found.clairvoyant["rms_error"] == pytest.approx(math.sqrt(np.mean(left**2)), rel=1e-6)


@pytest.mark.slow
def test_a_limit_is_what_its_search_says_and_does_not_depend_on_the_law_that_it_begins_with():
    one, other = (limit(replace(load_scenario(f"rig/1khz-{law}-square"), QUICK)) for law in ("pi", "tsmc"))
    for found in (one, other):
        sought = found.clairvoyant.attrs["sought_rms_error"]
        assert float(found.clairvoyant["rms_error"]) == pytest.approx(sought, rel=1e-7)
    for kind in ("causal", "clairvoyant"):
        first, second = (float(getattr(found, kind)["rms_error"]) for found in (one, other))
        assert first == pytest.approx(second, rel=1e-6)


def test_a_law_that_diverges_has_the_limits_of_one_that_does_not():
    """It begins the search with a machine at rest."""
    loop = replace(load_scenario("rig/1khz-pi-square"), QUICK)
    lost, found = limit(loop._replace(controller=Playback(np.full(251, np.nan)))), limit(loop)
    assert bool(lost.law["diverged"])
    assert float(lost.clairvoyant["rms_error"]) == pytest.approx(
        float(found.clairvoyant["rms_error"]), rel=1e-4
    )


def test_limits_without_a_law_are_those_with_one():
    """A search that begins with a machine at rest ends where one does that begins with a law's run."""
    loop = replace(load_scenario("rig/1khz-pi-square"), QUICK)
    found, alone = limit(loop), machine_limits(without_law(loop), command_limits(loop))
    assert alone.converged
    assert alone.clairvoyant == pytest.approx(float(found.clairvoyant["rms_error"]), rel=1e-6)
    assert alone.causal == pytest.approx(float(found.causal["rms_error"]), rel=1e-6)


def assert_no_law_is_below(loop: Loop) -> None:
    """A law's command is one of those among which the limit is the best."""
    found = limit(loop)
    law, causal, clairvoyant = (float(one["rms_error"]) for one in found)
    assert found.clairvoyant.attrs["converged"]
    assert clairvoyant <= law
    assert clairvoyant <= causal * (1.0 + 1e-6)


@pytest.mark.parametrize("name", ["rig/1khz-pi-square", "rig/1khz-tsmc-square"])
def test_no_law_is_below_its_limit(name: str):
    assert_no_law_is_below(replace(load_scenario(name), QUICK))


OTHERS = ["rig/encoder-tsmc-square", "rig/noisy-1khz-pi-square", "laws/lq-sine", "laws/mpc-square"]


@pytest.mark.slow
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, OTHERS, [*OTHERS][:1]))
def test_no_law_with_other_sensors_is_below_its_limit(name: str):
    loop = load_scenario(name)
    shorter = {"simulation.duration": 0.5}
    square = {"reference.period": 0.6} if hasattr(loop.reference, "period") else {}
    assert_no_law_is_below(replace(loop, {**shorter, **square}))
