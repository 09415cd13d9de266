"""The misprints: what each changes, and how the paper's loops take them."""

import pytest

from hydroservo import Loop
from hydroservo.control.controllers import PI, TSMC
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.theory import damping_ratio, proportional_gain_limit, settling_bound
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.papers.tsmc_eha_2021 import printed as laws
from hydroservo.papers.tsmc_eha_2021.printed import (
    PrintedBackstepping,
    PrintedTSMC,
    printed,
    printed_law,
    printed_leakage,
    printed_settling_bound,
)
from hydroservo.scenario import load_plugin, load_scenario
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block


def test_the_printed_leakage_is_smaller_by_the_area() -> None:
    meant = example(Loop).plant
    plant = printed_leakage(example(Loop)).plant
    ratio = plant.free_force_rate(0.0, 100.0) / meant.free_force_rate(0.0, 100.0)
    assert ratio == pytest.approx(meant.piston_area)
    assert plant.free_force_rate(0.1, 0.0) == meant.free_force_rate(0.1, 0.0)


def test_the_printed_leakage_leaves_next_to_no_damping() -> None:
    plant = printed_leakage(example(Loop)).plant
    assert damping_ratio(plant) == pytest.approx(0.004, abs=5e-4)
    limit = proportional_gain_limit(plant, example(FirstOrderValve), example(IdealSupply), 10.0)
    assert limit == pytest.approx(0.084, abs=5e-4)


@pytest.mark.parametrize(("name", "kind"), [("tsmc", PrintedTSMC), ("backstepping", PrintedBackstepping)])
def test_a_loop_to_the_letter_has_the_printed_law_and_leakage(name: str, kind: type) -> None:
    loop = load_scenario(f"paper/sine-{name}")
    letter = printed(loop)
    assert type(letter.controller) is kind
    assert letter.plant.leakage == loop.plant.piston_area * loop.plant.leakage
    believed = loop.controller.model.plant
    assert letter.controller.model.plant.leakage == believed.piston_area * believed.leakage


def test_a_printed_law_keeps_gains_and_parts() -> None:
    loop = example(Loop, controller=example(TSMC, linear_gain_1=7.0))
    assert printed_law(loop).controller._asdict().items() <= loop.controller._asdict().items()
    assert_same_block(printed_law(loop).plant, loop.plant)


def test_pi_is_as_it_is_printed() -> None:
    loop = example(Loop, controller=example(PI))
    assert printed_law(loop) == loop
    assert_same_block(printed(loop).controller, example(PI))


@pytest.mark.usefixtures("forgotten")
def test_a_printed_law_is_a_plugin_too() -> None:
    load_plugin(str(laws.__file__))
    loop = load_scenario("paper/sine-tsmc", {"controller.type": "PrintedTSMC"})
    assert type(loop.controller).__name__ == "PrintedTSMC"
    # Numbers alone: the classes of a plug-in are its own.
    assert loop.controller == printed_law(load_scenario("paper/sine-tsmc")).controller


def test_the_printed_bound_is_too_short() -> None:
    right = settling_bound(3.0, 0.5, 0.6, 2.0)
    assert printed_settling_bound(3.0, 0.5, 0.6, 2.0, start=1.0) == pytest.approx(1.0 + right * 0.4 / 1.6)
