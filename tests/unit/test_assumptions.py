"""What laws suppose: margins, and the published gains that fall short of Lemma 2."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import pytest

from hydroservo import Loop, load_scenario
from hydroservo import replace as replaced
from hydroservo.audits.audit import BlockAssumptions, assumptions_in
from hydroservo.audits.facts import LoopFacts
from hydroservo.audits.monitors import CommandPeaksValues, LumpedValues
from hydroservo.control.controlled import Position
from hydroservo.control.controllers import PI, PID
from hydroservo.control.references import Sine
from hydroservo.core.assumptions import Assumption, Peak, above, below, half_of_largest, near, per_second
from hydroservo.core.block import model_in
from hydroservo.machine.theory import damping_ratio, natural_frequency
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import scenarios

RUN = LumpedValues(16.7, 1.0, 1e4, 2.0, 8e3, 3.0, 50.0, 0.5, 1e5, 0.6, 5e4, 0.7)
COMMANDS = CommandPeaksValues(0.05, 1.0, 2.0, 0.1)


def facts(
    name: str,
    changes: dict[str, object] | None = None,
    *,
    found: LumpedValues | None = RUN,
    commands: CommandPeaksValues | None = COMMANDS,
) -> LoopFacts:
    loop = load_scenario(name, changes or {})
    begun = runnable_loop(loop)
    return LoopFacts(loop, begun, model_in(begun.controller), found, commands)


def named(name: str, path: str, told: LoopFacts) -> Assumption:
    (only,) = (
        one
        for block in assumptions_in(told.loop.controller, told)
        if block.path == path
        for one in block.assumptions or ()
        if one.name == name
    )
    return only


@pytest.mark.parametrize(
    ("one", "margin", "holds"),
    [
        (above("", "", 30.0, 15.0), 2.0, True),
        (above("", "", 30.0, Peak(60.0, 0.3)), 0.5, False),
        (above("", "", 30.0, 0.0), math.inf, True),
        (above("", "", 30.0, math.nan), math.nan, None),
        (below("", "", 0.0, 0.0), math.nan, None),
        (below("", "", Peak(4.0, 0.3), 10.0), 2.5, True),
        (near("", "", 5e-3, 10e-3, 1.5), 0.75, False),
        (near("", "", 10e-3, 10e-3, 1.5), 1.5, True),
        (near("", "", 10e-3, 0.0, 1.5), math.nan, None),
    ],
)
def test_margins(one: Assumption, margin: float, holds: bool | None) -> None:
    assert one.margin == pytest.approx(margin, nan_ok=True)
    assert one.holds is holds


def test_units_of_rates() -> None:
    assert [per_second(unit) for unit in ("m/s", "N")] == ["m/s^2", "N/s"]


def test_lemma_2_with_the_printed_gains() -> None:
    """D_1 = 30 holds by 1.8, D_2 = 100 is short by two orders of magnitude."""
    told = facts("paper/sine-tsmc")
    first, second = (named(f"Lemma 2, D_{i}", "controller.observer", told) for i in (1, 2))
    assert (first.value, first.bound, first.at, first.holds) == (30.0, 16.7, 1.0, True)
    assert first.margin == pytest.approx(30.0 / 16.7)
    assert (second.margin, second.at, second.holds) == (pytest.approx(0.01), 2.0, False)


def test_a_law_behind_an_inversion_is_late_by_what_that_does_not_know() -> None:
    told = facts("rig/1khz-tsmc-sine", {"valve.time_constant": 0.016})
    assert told.lag == pytest.approx(0.016)
    inner = told.loop.controller.within(told)
    assert inner.lag == pytest.approx(6e-3)
    assert inner.disturbances[1] == Peak(8e3, 3.0)
    assert told.disturbances[1] == Peak(1e4, 2.0)
    assert named("valve lag", "controller.controller", told).bound == pytest.approx(1.0 / 6e-3)
    assert named("valve known", "controller", told).margin == pytest.approx(2.0 / 1.6)


def test_what_no_run_has_told_cannot_be_told() -> None:
    told = facts("paper/sine-tsmc", found=None)
    assert named("Lemma 2, D_1", "controller.observer", told).holds is None


def test_feedback_linearisation_without_an_observer_has_a_threshold() -> None:
    """k1 k2 > omega_h^2 (gamma - beta)/gamma: 383^2 at +Delta, and none where the oil is softer."""
    changes = {"controller.controller.observer": {"type": "NoObserver"}}
    plus, minus = (
        named(
            "stiffness cancelled",
            "controller.controller",
            facts("laws/linear-sine", {**changes, "uncertainty.scale": scale}),
        )
        for scale in (1.0, -1.0)
    )
    assert math.sqrt(plus.bound) == pytest.approx(383.0, abs=1.0)
    assert (minus.bound, minus.margin) == (0.0, math.inf)


def test_the_frequency_and_the_noise_of_a_loop() -> None:
    told = facts("rig/noisy-1khz-tsmc-sine")
    assert told.demand_frequency == pytest.approx(0.25, rel=1e-4)
    assert told.noise == (pytest.approx(0.5e-3, rel=0.15), pytest.approx(5.0, rel=0.15))
    assert told.valve_lag == pytest.approx(10e-3)


@pytest.mark.parametrize("amplitude", [1e-200, 1e200, 1e308])
def test_the_frequency_of_a_demand_does_not_depend_on_its_size(amplitude: float) -> None:
    usual, told = (facts("rig/1khz-pi-sine", {"reference.amplitude": size}) for size in (0.1, amplitude))
    assert told.demand_frequency == pytest.approx(usual.demand_frequency, rel=1e-6)


def test_a_valve_that_follows_at_once_has_no_lag() -> None:
    assert facts("rig/1khz-tsmc-sine", {"valve.time_constant": 1e-300}).valve_lag == 0.0


def every_block() -> Iterator[BlockAssumptions]:
    """The blocks of the laws of the built-in scenarios, and what each supposes."""
    for name in scenarios():
        if name.startswith("laws/") and name.endswith("sine"):
            told = replace(facts(name), loop=runnable_loop(load_scenario(name)))
            yield from assumptions_in(told.loop.controller, told)


@pytest.mark.slow
def test_every_law_of_the_built_in_scenarios_says_what_it_supposes() -> None:
    """But for those of which nothing can be computed."""
    silent = {one.block for one in every_block() if one.assumptions is None}
    assert silent <= {
        "AntiWindup",
        "Biquad",
        "FilteredDerivative",
        "ModelDerivative",
        "ReferenceFilter",
        "RadialBasis",
    }


@pytest.mark.slow  # some ten seconds
def test_each_line_of_an_audit_says_by_itself_what_it_is_about() -> None:
    for one in every_block():
        meanings = [assumption.meaning for assumption in one.assumptions or ()]
        assert len(set(meanings)) == len(meanings), one
        assert not [text for text in meanings if text.startswith(("it ", "that "))], one


@pytest.mark.parametrize(("command", "asked_of"), [(9.9, False), (10.0, True), (math.nan, True)])
def test_a_horizon_is_supposed_where_a_limit_binds(command: float, asked_of: bool) -> None:
    """Elsewhere the moves change nothing, and their number is no matter."""
    told = facts("laws/mpc-sine", commands=COMMANDS._replace(command=command))
    names = [one.name for one in told.loop.controller.assumptions(told)]
    assert names == ["valve known", *(["horizon"] if asked_of else [])]


class Silent(NamedTuple):
    """A law that does not say what it supposes, around one that does."""

    controller: PI

    def step(self) -> None: ...


def test_a_law_that_brings_no_assumptions_is_listed_as_silent() -> None:
    told = facts("rig/1khz-pi-sine")
    outer, inner = assumptions_in(Silent(told.loop.controller), told)
    assert (outer.path, outer.block, outer.assumptions) == ("controller", "Silent", None)
    assert inner.path == "controller.controller"
    assert {one.name for one in inner.assumptions or ()} == {"small motions", "limits"}


def position_law(share: float) -> Loop:
    """The paper's machine, without lags and 10 % damped, with a share of 2 zeta omega/K_v as its gain."""
    changes = {"simulation.duration": 0.2, "simulation.period": 1e-5}
    loop = replaced(load_scenario("paper/sine-pi"), changes)
    plant = loop.plant._replace(damping=0.2 * loop.plant.damping, leakage=0.2 * loop.plant.leakage)
    flow = loop.valve.gain * loop.valve.orifice.simplified().flow_per_opening(loop.supply.drop())
    largest = 2.0 * damping_ratio(plant) * natural_frequency(plant) * plant.piston_area / flow
    reference = Sine(1e-4, 5.0, offset=plant.start_position)
    law = PID(share * largest)
    return loop._replace(plant=plant, controls=Position(), controller=law, reference=reference)


def gain_assumption(loop: Loop) -> Assumption:
    begun = runnable_loop(loop)
    return named("gain", "controller", LoopFacts(loop, begun, None, None, COMMANDS))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.25, 0.6])
def test_a_position_law_without_lags_has_half_of_the_textbook_gain(share: float) -> None:
    loop = position_law(share)
    found = gain_assumption(loop)
    assert found.value == loop.controller.proportional_gain
    assert found.margin == pytest.approx(0.5 / share, rel=0.04)  # 3 % from factor to factor of the onset
    assert found.holds is (share < 0.5)


def test_a_position_law_that_oscillates_has_no_largest_gain() -> None:
    found = gain_assumption(position_law(1.2))
    assert math.isnan(found.bound)
    assert (found.margin, found.holds) == (0.0, False)


def test_a_law_of_the_velocity_is_not_asked_for_it() -> None:
    told = facts("rig/1khz-pi-sine")
    assert not half_of_largest(1.0, "m/s", told)
    assert not half_of_largest(0.0, "m", told)
