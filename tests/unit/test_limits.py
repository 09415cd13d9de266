"""Limits: machines written with symbols, limits of commands, what is known when, and what is refused."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, ParameterError, limit, limit_over_periods, load_scenario, plot, replace
from hydroservo.control.controlled import Command
from hydroservo.control.controllers import DAC, PI, Delay, OpenLoop, RateLimit, Saturation
from hydroservo.control.holds import DelayedHold
from hydroservo.control.loop import AUTO
from hydroservo.control.references import Ramp, Sine, Square
from hydroservo.core.block import Block, Field, values
from hydroservo.core.roles import Controller
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.states import filled
from hydroservo.limits.command import CommandLimits, command_limits, loosest_limits
from hydroservo.limits.least_error import Limits, unless_worse, without_law
from hydroservo.limits.over_periods import checked_periods
from hydroservo.limits.problem import machine_functions
from hydroservo.limits.search import expected_course, foreknowledge, jump_steps, surprises
from hydroservo.machine.integrators import Tsit5
from hydroservo.machine.loads import Step as LoadStep
from hydroservo.machine.mechanics.viscous import ViscousState
from hydroservo.runs.provenance import canonical_toml
from hydroservo.runs.run import runnable_loop
from hydroservo.runs.step_sizes import at_period

MACHINES = [
    "paper/sine-pi",
    "rig/1khz-pi-sine",
    "rig/excavator-link",
    "axis/position",
    "axis/force",
    "axis/crane",
    "axis/pump-controlled",
    "cases/drift",
]


def rig(**changes: object) -> Loop:
    return replace(load_scenario("rig/1khz-pi-square"), changes)


@pytest.mark.parametrize("name", MACHINES)
def test_symbols_give_the_rates_of_the_text(name: str):
    loop = runnable_loop(load_scenario(name))
    like = loop.machine(loop.init())
    rates, signal = machine_functions(loop)
    first, random = np.array(values(like)), np.random.default_rng(1)
    for _ in range(20):
        numbers = first * random.uniform(0.9, 1.1, first.size) + random.uniform(-1e-4, 1e-4, first.size)
        command, force = random.uniform(-2.0, 2.0), random.uniform(-100.0, 100.0)
        state = filled(like, iter(numbers.tolist()))
        ours = np.array(values(loop.rates(state, command, force)))
        assert np.array(rates(numbers, command, force)).ravel() == pytest.approx(ours, rel=1e-9, abs=1e-7)
        seen = loop.controls.of(loop.seen(state, force), command)
        assert float(signal(numbers, command, force)) == pytest.approx(seen, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "limits"),
    [
        (PI(1.0, 1.0), (10.0, np.inf, 0)),
        (DAC(PI(1.0, 1.0), limit=5.0), (5.0, np.inf, 0)),
        (DAC(PI(1.0, 1.0, saturation=Saturation(2.0)), limit=5.0), (2.0, np.inf, 0)),
        (Delay(Delay(RateLimit(PI(1.0, 1.0), 30.0))), (10.0, 30.0, 2)),
    ],
)
def test_what_limits_a_command(law: object, limits: tuple[float, float, int]):
    assert command_limits(rig()._replace(controller=law))[:3] == limits


class Choosy(NamedTuple):
    """Friction that asks of a velocity what can be asked of no symbol."""

    coefficient: Annotated[float, Field("N", "friction", "example")] = 1.0

    def init(self) -> ViscousState:
        return ViscousState()

    def deriv(self, s: ViscousState, velocity: float) -> ViscousState:
        return s

    def force(self, s: ViscousState, velocity: float, net: float, mass: float) -> float:
        return self.coefficient if velocity > 0.0 else -self.coefficient


def test_the_loosest_limits_allow_what_any_law_may_give():
    laws = [DAC(PI(1.0, 1.0), limit=5.0), Delay(RateLimit(PI(1.0, 1.0), 30.0)), DAC(PI(1.0, 1.0), limit=8.0)]
    found = loosest_limits([command_limits(rig()._replace(controller=law)) for law in laws])
    assert found == CommandLimits(10.0, np.inf, 0, 1e-3)


def test_a_loop_without_a_law_is_the_same_whatever_law_it_had():
    one, other = (replace(load_scenario(f"rig/{name}-square"), {}) for name in ("1khz-pi", "noisy-1khz-tsmc"))
    assert canonical_toml(one) != canonical_toml(other)
    assert canonical_toml(without_law(one)) == canonical_toml(without_law(other))
    assert canonical_toml(without_law(one)) != canonical_toml(without_law(rig(**{"plant.mass": 7.0})))


def test_a_block_that_cannot_be_written_with_symbols_is_named():
    loop = load_scenario("axis/position")
    choosy = runnable_loop(loop._replace(plant=loop.plant._replace(friction=Choosy())))
    with pytest.raises(ParameterError, match=r"Choosy\.force.*cannot be written with symbols"):
        machine_functions(choosy)


class Endless(NamedTuple):
    """A law of no limit."""

    def init(self) -> object: ...


def test_a_law_without_a_limit_has_its_valves():
    assert command_limits(rig()._replace(controller=Endless())).limit == pytest.approx(10.0)
    bare = rig()._replace(controller=Endless(), valve=Endless())
    with pytest.raises(ParameterError, match="has no limit of its command: put a DAC around it"):
        command_limits(bare)


def test_jumps_are_seen_and_what_is_smooth_is_not():
    samples = 300
    square = foreknowledge(rig(reference=Square(0.03, 0.2), load=LoadStep(0.0, 50.0, 0.25)), samples)
    assert [(found / 10).tolist() for found in jump_steps(square)] == [[100.0, 200.0], [250.0]]
    ramp = foreknowledge(rig(reference=Ramp(0.0, 0.01, 0.1, 0.05)), samples)
    assert [(found / 10).tolist() for found in jump_steps(ramp)] == [[50.0, 150.0], []]
    sine = foreknowledge(rig(reference=Sine(0.03, 20.0)), samples)
    assert not any(found.size for found in jump_steps(sine))


def test_until_a_jump_is_there_a_demand_goes_on_and_a_load_stays():
    known = foreknowledge(rig(reference=Ramp(0.0, 0.01, 0.1, 0.05), load=LoadStep(0.0, 50.0, 0.1)), 300)
    before = expected_course(known, 1)
    assert not before.demand.any()
    assert not before.force.any()
    on_the_way = expected_course(known, 501)
    assert on_the_way.demand[1500:] == pytest.approx(0.1 * (np.arange(1500, 3000) * 1e-4 - 0.05))
    assert np.array_equal(on_the_way.demand[:1500], known.demand[:1500])
    assert not on_the_way.force.any()
    assert np.array_equal(expected_course(known, 1501).demand, known.demand)


def test_a_delayed_law_tells_of_a_jump_later():
    known = foreknowledge(rig(reference=Square(0.03, 0.2)), 150)
    assert surprises(known, CommandLimits(10.0, np.inf, 0, 1e-3), 150) == [0, 100, 150]
    assert surprises(known, CommandLimits(10.0, np.inf, 3, 1e-3), 150) == [0, 103, 150]


def test_an_open_loop_has_no_limit():
    loop = rig()._replace(controls=Command(), controller=OpenLoop())
    with pytest.raises(ParameterError, match="an open loop has no limit"):
        limit(loop)


def test_an_integrator_that_chooses_its_steps_is_refused():
    with pytest.raises(ParameterError, match=r"Tsit5.*chooses its steps"):
        limit(rig(**{"simulation.integrator": Tsit5()}))


def test_periods_must_be_different_numbers_within_the_run():
    assert checked_periods([0.01, 0.001], 0.1) == [0.001, 0.01]
    for periods, problem in (
        ([], "at least one number"),
        ([math.nan], "must be above 0"),
        ([math.inf], "must be above 0"),
        ([True], "must be numbers"),
        (["1 ms"], "must be numbers"),
        ([0.2], "must be at most the duration, 0.1 s"),
        ([0.01, 0.01], "is there twice"),
    ):
        with pytest.raises(ParameterError, match=problem):
            checked_periods(periods, 0.1)


def test_another_period_keeps_the_delay_s_share_and_the_length_of_steps():
    loop = rig(hold=DelayedHold(5e-4))
    found = at_period(loop, 4e-3)
    assert found.hold == DelayedHold(2e-3)
    assert found.simulation == loop.simulation._replace(period=4e-3, substeps=40)
    assert at_period(loop, 3e-4).simulation.substeps == 3
    assert at_period(rig(**{"simulation.substeps": AUTO}), 4e-3).simulation.substeps == AUTO


class OnlyFast(NamedTuple):
    """A law that can be designed for short sample periods alone."""

    controller: Controller

    def designed(self, model: object, period: float) -> "OnlyFast":
        if period > 2e-3:
            raise ParameterError("period", period, "must be at most 2 ms")
        return self

    def init(self) -> object:
        return self.controller.init()

    def step(self, s: Block, y: Measurement, r: Demand, dt: float) -> Block:
        return self.controller.step(s, y, r, dt)


@pytest.mark.slow
def test_a_law_that_cannot_run_at_a_period_leaves_its_limits():
    loop = rig(**{"simulation.duration": 0.06, "reference.period": 0.06})
    fast = loop._replace(controller=OnlyFast(loop.controller))
    found = limit_over_periods(fast, [1e-3, 4e-3])
    first, second = found.at
    assert not first.reason
    assert math.isnan(second.law)
    assert "must be at most 2 ms" in second.reason
    alone = limit_over_periods(loop, [4e-3]).at[0]
    assert (second.causal, second.clairvoyant) == pytest.approx((alone.causal, alone.clairvoyant), rel=1e-4)
    assert plot(found).axes[0].get_xscale() == "log"
    assert "must be at most 2 ms" in found._repr_html_()


@pytest.mark.slow
def test_a_law_that_goes_unstable_does_not_spoil_the_limits():
    """Its gains are too large at 10 ms, and no search from its run ends there."""
    loop = rig(**{"simulation.duration": 0.1, "reference.period": 0.1})
    calm = {"controller.proportional_gain": 0.1, "controller.integral_gain": 50.0}
    (wild,), (still,) = (limit_over_periods(loop, periods).at for periods in ([0.01], {0.01: calm}))
    assert wild.law > 10.0 * still.law
    assert wild.causal == pytest.approx(still.causal, rel=1e-3)
    assert wild.clairvoyant < still.law


def test_a_limit_above_what_another_command_leaves_is_none():
    run = xr.Dataset({"rms_error": 2.0}, attrs={"converged": True})
    assert unless_worse(run, 1.9999) is run
    worse = unless_worse(run, 1.0)
    assert worse.attrs["converged"] is False
    assert "another command leaves less" in worse.attrs["warning"]
    law = xr.Dataset({"rms_error": 4.0})
    multiples = Limits(law, worse, run).multiples()
    assert math.isnan(multiples["causal"])
    assert multiples["clairvoyant"] == 2.0
