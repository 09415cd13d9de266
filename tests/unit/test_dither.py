"""Dither: its wave, its phase over long runs, what the law in it learns, and what it does against play."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hydroservo as hs
from hydroservo import Loop, load_scenario, replace
from hydroservo.audits.oscillation import OSCILLATION, sustained_oscillation, with_still_command
from hydroservo.control.controlled import Command, Velocity
from hydroservo.control.controllers import DAC, PI, Dither, FixedDemand, ForceLimit, OpenLoop, Saturation
from hydroservo.control.controllers.dither import DitherState, without_dither
from hydroservo.control.references import Ramp, Step
from hydroservo.core.signals import Demand, Measurement
from hydroservo.limits.command import command_limits
from hydroservo.runs.cautions.loop import coarse_dither

REST = Measurement(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
STILL = Demand(0.0, 0.0, 0.0)
H = 1e-3


def wave(frequency: float, samples: int, period: float = H) -> np.ndarray:
    law, found = Dither(OpenLoop(), 1.0, frequency), []
    s: Any = law.init()
    for _ in range(samples):
        s = law.step(s, REST, STILL, period)
        found.append(s.u)
    return np.array(found)


def mean_of_square(frequency: float, samples: int, period: float) -> np.ndarray:
    """The mean of sgn(sin(2 pi f t)) over each sample, from its integral in closed form."""
    t = period * np.arange(samples + 1)
    phase = np.mod(frequency * t, 1.0)
    integral = (0.5 - np.abs(phase - 0.5)) / frequency
    return np.diff(integral) / period


def test_a_whole_number_of_samples_a_half_period_is_a_square_wave() -> None:
    assert wave(100.0, 20).tolist() == 2 * (5 * [1.0] + 5 * [-1.0])
    assert wave(500.0, 6).tolist() == 3 * [1.0, -1.0]


@given(st.floats(1.0, 500.0))
def test_each_sample_has_the_mean_of_the_wave_over_it(frequency: float) -> None:
    found = wave(frequency, 300)
    assert found == pytest.approx(mean_of_square(frequency, 300, H), abs=1e-9)
    assert np.abs(found).max() <= 1.0 + 1e-9


@pytest.mark.parametrize("frequency", [125.0, 150.0, 333.0, 7.0])
def test_its_mean_over_a_second_is_zero(frequency: float) -> None:
    assert wave(frequency, 1000).mean() == pytest.approx(0.0, abs=1e-15)


def test_the_phase_does_not_drift_in_a_year() -> None:
    """After a whole number of seconds the count is 0 to the bit, so that each second is as the first was."""
    law = Dither(OpenLoop(), 0.2, 137.0)
    s: Any = law.init()
    for _ in range(1000):
        s = law.step(s, REST, STILL, H)
    assert s == DitherState(s.u, s.added, 0.0, s.controller)


@pytest.mark.parametrize("demand", [0.6, 30.0])
def test_at_a_limit_the_law_learns_in_the_mean_of_what_was_applied(demand: float) -> None:
    law = Dither(PI(0.5, 0.0, anti_windup=0.0, saturation=Saturation(5.0), controls=Velocity()), 0.4, 100.0)
    outer = DAC(law, bits=32, limit=5.0)
    s: Any = outer.init()
    applied, learnt = [], []
    for _ in range(40):
        learnt.append(s.u - s.controller.added)
        applied.append(s.u)
        s = outer.step(s, REST._replace(command=s.u), Demand(demand, 0.0, 0.0), H)
    assert np.mean(learnt[-20:]) == pytest.approx(np.mean(applied[-20:]), abs=1e-7)


def position(**changes: object) -> Loop:
    """A position held against a valve with play, behind a dither."""
    loop = load_scenario("axis/position")
    return replace(loop._replace(controller=Dither(loop.controller.controller, 0.1, 100.0)), changes)


def test_a_frequency_near_half_the_sample_rate_is_doubtful() -> None:
    assert list(coarse_dither(position(**{"controller.frequency": 500.0}))) == [
        "controller.frequency is 500 Hz, 2 samples a period; a square wave needs 4, 250 Hz here"
    ]
    assert not list(coarse_dither(position(**{"controller.frequency": 250.0})))


def creep(amplitude: float, width: float) -> float:
    """How far the spool is off at the end of a slow rise of the command [V]; the valve has no overlap."""
    loop = load_scenario("axis/position")
    parts = {"reference": Ramp(0.0, 0.3, 0.5, 0.0), "controls": Command()}
    loop = loop._replace(controller=Dither(OpenLoop(), amplitude, 100.0), **parts)
    loop = replace(loop, {"simulation.duration": 1.0, "valve.hysteresis": width})
    run = hs.simulate(loop, record=["valve.opening"])
    late = run["time"].values >= 0.8  # twenty whole periods
    return float(0.3 - run["valve.opening"].values[late][:-1].mean() / loop.valve.gain)


def test_play_is_taken_away_by_a_dither_that_is_wider_and_not_by_a_smaller_one() -> None:
    width = 4e-6
    half = 0.5 * width / load_scenario("axis/position").valve.gain
    assert creep(0.0, width) == pytest.approx(half, rel=0.02)
    assert creep(0.5 * half, width) == pytest.approx(half - 0.5 * half, rel=0.1)
    assert abs(creep(3.0 * half, width)) < 0.05 * half


@pytest.mark.slow
def test_an_oscillation_that_it_is_names_it() -> None:
    loop = position(**{"simulation.duration": 1.0, "controller.amplitude": 0.2})
    loop = loop._replace(reference=Step(loop.plant.start_position, loop.plant.start_position, 0.1))
    found = sustained_oscillation(loop, hs.simulate(loop, record=["controller.u"], metrics=[OSCILLATION]))
    assert found is not None
    assert found.frequency == pytest.approx(100.0, rel=1e-3)
    assert [one.cause for one in found.causes] == ["dither"]


def test_small_motions_limits_and_forecasts_are_those_without_it() -> None:
    loop = position()
    law = loop.controller.controller
    assert without_dither(DAC(loop.controller)) == DAC(Dither(law, 0.0, 100.0))
    pressing = FixedDemand(loop.controller, 1e4)
    assert without_dither(ForceLimit(law, pressing)).limiting.controller == Dither(law, 0.0, 100.0)
    assert command_limits(loop) == command_limits(loop._replace(controller=law))
    assert with_still_command(loop._replace(controller=law)) is None
    bare = hs.linearize(loop._replace(controller=law), unit="loop", command=1.0)
    poles = hs.linearize(loop, unit="loop", command=1.0).poles
    nearest = [min(abs(poles - pole)) for pole in bare.poles]
    assert max(nearest) < 1e-6 * max(abs(bare.poles))
    assert math.isfinite(min(nearest))
