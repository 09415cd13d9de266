"""At which gain loops start to oscillate, against runs of their own with gains raised."""

import math

import numpy as np
import pytest

import hydroservo as hs
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.core.block import leaves
from hydroservo.core.group import nested
from hydroservo.linear.onset import first_lasting_swing, oscillation_gain, with_amplified_command
from hydroservo.machine.starts import AsBuilt

PI = ("proportional_gain", "integral_gain")
FACTORS = 10.0 ** (np.arange(0.0, 1.1, 0.25) / 20.0)


def decibels(factor: float) -> float:
    return 20.0 * math.log10(factor)


def swing(loop: Loop, gains: list[str], raised: float) -> float:
    """The command's amplitude [V] in a run with the law's own gains raised by some dB."""
    numbers = {path: number_at(loop, path) * 10.0 ** (raised / 20.0) for path in gains}
    run = hs.replace(loop, numbers | {"simulation.duration": loop.simulation.duration + 5.0})
    return float(hs.simulate(run, metrics=[Oscillation()], record=[])["oscillation_command"])


def number_at(loop: Loop, path: str) -> float:
    return float(dict(leaves(loop))[path])


@pytest.mark.parametrize(
    ("scenario", "law"),
    [
        ("examples/axis.toml", "controller"),
        ("axis/force", "controller.controller"),
        ("rig/1khz-pi-square", "controller"),
    ],
)
def test_the_onset_is_where_single_runs_with_raised_gains_begin_to_oscillate(scenario: str, law: str) -> None:
    loop = hs.load_scenario(scenario)
    onset = decibels(oscillation_gain(loop))
    gains = [f"{law}.{name}" for name in PI]
    assert swing(loop, gains, onset - 0.75) < 0.1
    assert swing(loop, gains, onset + 0.75) > 0.1


def test_where_the_demand_hardly_moves_it_is_the_linear_gain_margin() -> None:
    """Within two of its steps: just above the margin the oscillation grows too slowly to count."""
    loop = hs.replace(hs.load_scenario("examples/axis.toml"), {"reference.amplitude": 1e-4})
    margin = float(hs.bode(loop, measure=False)["gain_margin"])
    assert decibels(oscillation_gain(loop)) == pytest.approx(decibels(margin), abs=0.5)


def test_a_loop_that_oscillates_as_it_stands_has_one() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square")
    gains = {f"controller.{name}": 3.0 * number_at(loop, f"controller.{name}") for name in PI}
    assert oscillation_gain(hs.replace(loop, gains)) == 1.0


def test_a_loop_without_feedback_of_any_size_has_none() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square")
    gains = {f"controller.{name}": 1e-3 * number_at(loop, f"controller.{name}") for name in PI}
    assert oscillation_gain(hs.replace(loop, gains)) == math.inf


def test_a_swing_with_one_factor_alone_is_no_onset() -> None:
    assert first_lasting_swing(FACTORS, np.array([0.0, 1.0, 0.0, 1.0, 1.0])) == FACTORS[3]
    assert first_lasting_swing(FACTORS, np.array([0.0, 0.0, 0.0, 0.0, 1.0])) == math.inf
    assert first_lasting_swing(FACTORS, np.array([1.0, 0.0, 0.0, 0.0, 0.0])) == 1.0


def test_what_cannot_be_told_below_an_onset_is_not_told() -> None:
    assert math.isnan(first_lasting_swing(FACTORS, np.array([0.0, math.nan, 0.0, 1.0, 1.0])))
    assert first_lasting_swing(FACTORS, np.array([0.0, 1.0, 1.0, math.nan, 0.0])) == FACTORS[1]


def test_given_states_of_the_law_reach_it() -> None:
    loop = hs.load_scenario("rig/1khz-pi-square")
    given = AsBuilt(nested({"controller.integral": 0.5, "plant.velocity": 0.1}))
    assert (
        with_amplified_command(loop._replace(start=given)).start.given.controller.controller.integral == 0.5
    )
    assert math.isfinite(
        oscillation_gain(loop._replace(start=AsBuilt(nested({"controller.integral": 0.01}))))
    )
