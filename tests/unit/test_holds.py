"""Commands between samples: when they come, and what integrators make of it."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import Field, Loop, ParameterError, Simulation, ops, replace, simulate, simulate_batch
from hydroservo.control.controllers import PI
from hydroservo.control.holds import DelayedHold, ZeroOrderHold
from hydroservo.control.references import Ramp
from hydroservo.core.block import Block
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.integrators import RK4, Tsit5
from hydroservo.runs.step_sizes import command_parts, largest_difference
from hydroservo.testing.examples import example

H = 1e-3
LAW = PI(0.3, 100.0)
LOOP = example(Loop, Simulation(0.1, H, 8, record_period=H), controller=LAW, hold=DelayedHold(0.5 * H))


@given(st.floats(0.0, 10.0), st.floats(0.01, 1.0), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_a_delayed_command_comes_when_it_is_due(t: float, share: float, last: float, u: float) -> None:
    hold = DelayedHold(share * H)
    s = hold.step(hold.init(), last, t)
    held = hold.held(s, u)
    switch = t + share * H
    for ahead in (0.0, 0.5, 0.99):
        assert hold.at(held, t + ahead * share * H) == (u if last == u else last)
    for later in (switch, switch + 0.5 * H):
        assert hold.at(held, later) == u
    jump = hold.next_jump(held, t)
    assert jump == switch
    assert hold.at(held, jump) == u
    assert hold.next_jump(held, jump) == math.inf


def test_a_command_without_delay_comes_at_once() -> None:
    held = DelayedHold(0.0).held(DelayedHold(0.0).step(example(DelayedHold).init(), 1.0, 0.3), 2.0)
    assert DelayedHold(0.0).at(held, 0.3) == 2.0
    assert ZeroOrderHold().at(ZeroOrderHold().held(ZeroOrderHold().init(), 2.0), 0.3) == 2.0


@given(st.floats(0.0, 1.0), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_what_was_applied_is_the_mean_over_the_period(share: float, last: float, u: float) -> None:
    hold = DelayedHold(share * H)
    s = hold.step(hold.init(), last, 0.0)
    held = hold.held(s, u)
    middles = H * (np.arange(10_000) + 0.5) / 10_000
    mean = np.mean([hold.at(held, float(t)) for t in middles])
    assert hold.applied(s, u, H) == pytest.approx(mean, abs=20.0 / 10_000)


class HalfState(NamedTuple):
    u: Annotated[float, Field("V", "command that is put out")]
    fresh: Annotated[float, Field("", "1 if the law has just run")]
    law: Block


class EverySecond(NamedTuple):
    """A law that runs at every second sample; its command is put out at the sample in between."""

    law: Block = LAW

    def init(self) -> HalfState:
        return HalfState(0.0, 0.0, self.law.init())

    def step(self, s: HalfState, y: Measurement, r: Demand, dt: float) -> HalfState:
        after = self.law.step(s.law, y, r, 2.0 * dt)
        runs = s.fresh == 0.0
        return HalfState(
            ops.where(runs, s.u, s.law.u), ops.where(runs, 1.0, 0.0), ops.where(runs, after, s.law)
        )


@pytest.fixture(scope="module")
def delayed() -> object:
    return simulate(LOOP, strict=True)


@pytest.mark.slow  # compiles whole loops
def test_half_a_period_of_delay_is_a_law_at_every_second_of_twice_as_many_samples(delayed: object) -> None:
    simulation = LOOP.simulation._replace(period=0.5 * H, substeps=4)
    fast = LOOP._replace(simulation=simulation, controller=EverySecond(), hold=ZeroOrderHold())
    assert largest_difference(LOOP, delayed, simulate(fast, strict=True)) < 1e-9


def test_a_delay_matters(delayed: object) -> None:
    assert largest_difference(LOOP, delayed, simulate(LOOP._replace(hold=ZeroOrderHold()))) > 1e-3


def test_what_the_law_hears_is_the_mean_of_two_commands() -> None:
    """Seen by the law's back-calculation, whose integral moves by what was not applied."""
    law = LAW._replace(integral_gain=0.0, anti_windup=100.0)
    run = simulate(LOOP._replace(controller=law, hold=DelayedHold(0.25 * H)), strict=True)
    u, integral = run["controller.u"].values, run["controller.integral"].values
    applied = 0.25 * np.concatenate([[0.0, 0.0], u[:-2]]) + 0.75 * np.concatenate([[0.0], u[:-1]])
    moved = H * 100.0 * (applied - np.concatenate([[0.0], u[:-1]]))
    assert np.diff(integral) == pytest.approx(moved[1:], rel=0.0, abs=1e-15)
    assert np.abs(moved).max() > 1e-7


SMOOTH = LOOP._replace(reference=Ramp(0.0, 0.03, rate=0.2, time=0.0), hold=DelayedHold(0.25 * H))


@pytest.mark.slow  # compiles whole loops
def test_rk4_keeps_its_order_where_substeps_end_on_the_command() -> None:
    """Its error falls by 2^4 with twice as many; the adaptive method finds the switch by itself."""
    exact = simulate(replace(SMOOTH, {"simulation.integrator": Tsit5(1e-12), "simulation.substeps": 1}))
    errors = [
        largest_difference(SMOOTH, simulate(replace(SMOOTH, {"simulation.substeps": n})), exact)
        for n in (4, 8, 16)
    ]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(4.0, abs=0.3)
    assert errors[-1] < 1e-5


def test_automatic_substeps_end_on_the_command() -> None:
    run = simulate(replace(SMOOTH, {"simulation.substeps": "auto", "hold.delay": 0.4 * H}), record=[])
    assert run.attrs["substeps"] % 5 == 0
    assert "warning" not in run.attrs


@pytest.mark.parametrize(
    ("share", "parts"), [(0.0, 1), (0.5, 2), (0.25, 4), (0.6, 5), (1.0, 1), (1.0 / 3.0, 3), (0.99, 100)]
)
def test_parts_of_a_period(share: float, parts: int) -> None:
    assert command_parts(replace(LOOP, {"hold.delay": share * H})) == parts


@pytest.mark.parametrize("digits", [1.0 / 3.0 - 3e-10, 1.0 / 3.0 + 3e-10])
def test_a_share_in_ten_digits_is_the_share(digits: float) -> None:
    thirds = replace(LOOP, {"simulation.substeps": 3})
    third, near = (replace(thirds, {"hold.delay": share * H}) for share in (1.0 / 3.0, digits))
    assert largest_difference(LOOP, simulate(near), simulate(third)) == 0.0


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"hold.delay": 2.0 * H}, "hold.delay = 0.002: must be at most the sample period of 0.001 s"),
        (
            {"hold.delay": 0.1234 * H},
            "hold.delay = 0.0001234: must be k/n of the period of 0.001 s, n to 100",
        ),
        ({"hold.delay": -1.0}, "hold.delay = -1.0: must be a finite number at least 0 [s]"),
        (
            {"simulation.substeps": 7},
            "simulation.substeps = 7: must be a multiple of 2, for the hold's delay",
        ),
    ],
)
def test_a_delay_that_no_substep_can_end_on_is_refused(changes: dict[str, float], says: str) -> None:
    with pytest.raises(ParameterError) as error:
        simulate(replace(LOOP, changes))
    assert str(error.value) == says


def test_the_adaptive_method_needs_no_such_substeps() -> None:
    odd = replace(LOOP, {"simulation.substeps": 7, "simulation.integrator": Tsit5(1e-10)})
    even = replace(LOOP, {"simulation.substeps": 64, "simulation.integrator": RK4()})
    assert largest_difference(LOOP, simulate(odd), simulate(even)) < 1e-7


def test_the_adaptive_method_takes_any_delay_up_to_a_period() -> None:
    loop = replace(LOOP, {"simulation.integrator": Tsit5(), "hold.delay": 0.314159e-3})
    assert command_parts(loop) == 1
    with pytest.raises(ParameterError, match=r"hold\.delay.*at most the sample period"):
        command_parts(replace(loop, {"hold.delay": 1.1e-3}))


def test_a_batch_refuses_what_a_run_refuses() -> None:
    masses = {"plant.mass": np.array([5.0, 6.0])}
    for changes in ({"simulation.substeps": 3}, {"hold.delay": 2e-3}):
        wrong = replace(LOOP, changes)
        for run in (simulate, lambda loop: simulate_batch(loop, masses)):
            with pytest.raises(ParameterError, match=r"hold"):
                run(wrong)
    with pytest.raises(ParameterError, match=r"hold\.delay"):
        simulate_batch(LOOP, {"hold.delay": np.array([1e-4, 5e-4])})
