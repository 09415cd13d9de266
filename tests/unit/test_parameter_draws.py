"""What is drawn for the runs of a batch, and one run of it alone."""

from typing import Any

import numpy as np
import pytest

from hydroservo import Loop, ParameterError, ScenarioError, Simulation, draws, relative, run_of
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.loop import AUTO
from hydroservo.core.block import Block
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.run import simulate
from hydroservo.scenario import assemble, load_scenario
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block

NAME = "paper/sine-backstepping"  # whose law has a model, and whose machine has uncertainty
LOOP = example(Loop, Simulation(0.002, 1e-4), plant=example(LoadPressurePlant, mass=6))
MASS = "plant.mass"


def test_ranges_are_numbers_texts_or_relative() -> None:
    same = [(4.2, 7.8), "4.2..7.8 kg", "4200 g .. 7.8 kg", "x0.7..x1.3", "-30%..+30%", relative(-0.3, 0.3)]
    for one in same:
        assert draws(LOOP, {MASS: one}, 3).ranges[MASS] == pytest.approx((4.2, 7.8), rel=1e-12)
    texts, numbers = (draws(LOOP, {MASS: one}, 9).parameters[MASS] for one in same[-2:])
    np.testing.assert_array_equal(texts, numbers)


def test_numbers_are_a_function_of_seed_path_and_run_alone() -> None:
    """These are what the same command draws in any release."""
    found = draws(load_scenario(NAME), {MASS: (4.0, 8.0)}, 3, seed=7).parameters[MASS]
    more = draws(load_scenario(NAME), {"load.offset": (-1, 1), MASS: (4, 8)}, 50, seed=7).parameters[MASS]
    np.testing.assert_array_equal(found, more[:3])
    assert found.tolist() == [4.583443512569565, 4.1200092769884495, 4.563583881464272]


def test_relative_ranges_of_a_scenario_are_around_its_nominal_machine() -> None:
    changes = {"uncertainty.plant.mass": 0.5, "uncertainty.scale": 1}
    usual = {MASS: relative(-0.1, 0.1)}
    scenario = assemble(NAME, changes)
    assert draws(scenario, usual, 2).ranges[MASS] == pytest.approx((5.4, 6.6))
    assert draws(scenario.loop, usual, 2).ranges[MASS] == pytest.approx((8.1, 9.9))


def test_what_a_run_is_made_of_is_the_truth_of_the_machine_and_values_elsewhere() -> None:
    ranges = {MASS: relative(-0.3, 0.3), "controller.velocity_gain": (1500.0, 2500.0)}
    drawn = draws(assemble(NAME), ranges, 5, seeds=True)
    assert list(drawn.changes(2)) == ["truth.plant.mass", "controller.velocity_gain", "simulation.seed"]
    for run in range(5):
        own = {path: column[run].item() for path, column in drawn.parameters.items()}
        loop = load_scenario(NAME, drawn.changes(run))
        assert loop.plant.mass == own[MASS]
        assert loop.controller.velocity_gain == own["controller.velocity_gain"]
        assert_same_block(loop.controller.model, load_scenario(NAME).controller.model)
        assert loop.simulation.seed == own["simulation.seed"] == run
    np.testing.assert_allclose(6.0 * (1.0 + drawn.deviations[MASS]), drawn.values[MASS], rtol=1e-15)


def test_what_constructors_take_varies_in_a_scenario() -> None:
    rated = {
        "type": "Orifice.rated",
        "rated_flow": "40 L/min",
        "rated_drop": "70 bar",
        "rated_opening": "5 mm",
    }
    scenario = assemble(NAME, {"valve.orifice": rated})
    drawn = draws(scenario, {"valve.orifice.rated_flow": relative(-0.1, 0.1)}, 4)
    assert list(drawn.parameters) == ["valve.orifice.area_gradient"]
    assert list(drawn.changes(0)) == ["truth.valve.orifice.rated_flow"]
    again = load_scenario(NAME, {"valve.orifice": rated, **drawn.changes(3)})
    assert again.valve.orifice.area_gradient == drawn.parameters["valve.orifice.area_gradient"][3]
    with pytest.raises(ScenarioError, match=r"ranges: valve\.orifice\.rated_flow: must be one of"):
        draws(scenario.loop, {"valve.orifice.rated_flow": (1e-4, 1e-3)}, 4)


@pytest.mark.parametrize(
    ("controller", "simulation"),
    [
        (example(PI), LOOP.simulation),
        (example(TSMC), LOOP.simulation),
        (example(PI), Simulation(0.002, 1e-4, AUTO)),
    ],
)
def test_a_run_alone_has_the_bits_of_the_batch(controller: Block, simulation: Simulation) -> None:
    """A law without a model of its own goes on believing in the machine that all runs start from."""
    loop = LOOP._replace(controller=controller, simulation=simulation)
    drawn = draws(loop, {MASS: relative(-0.5, 0.5), "plant.damping": (30.0, 90.0)}, 5, seeds=True)
    table = simulate_batch(loop, drawn.parameters, strict=True)
    for run in range(5):
        single = simulate(run_of(loop, table, run), record=(), strict=True)
        assert float(single["rms_error"]) == float(table["rms_error"][run])


def test_a_run_starts_where_that_of_the_batch_does() -> None:
    loop = LOOP._replace(plant=example(Cylinder))
    drawn = draws(loop, {"supply.supply_pressure": relative(0.0, 0.5)}, 2)
    table = simulate_batch(loop, drawn.parameters, strict=True)
    single = simulate(run_of(loop, table, 1), record=(), strict=True)
    assert float(single["pressure_max"]) == float(table["pressure_max"][1])


@pytest.mark.parametrize(
    ("ranges", "more", "error", "problem"),
    [
        ({"plant.mss": (1, 2)}, {}, ScenarioError, "ranges: plant.mss: .*; did you mean plant.mass"),
        ({MASS: (2, 1, 3)}, {}, ScenarioError, r"ranges: plant.mass: \(2, 1, 3\) must be a range"),
        ({MASS: 3.0}, {}, ScenarioError, "ranges: plant.mass: 3.0 must be a range"),
        ({MASS: (1, float("nan"))}, {}, ScenarioError, "must be a finite number above 0"),
        ({MASS: (2, 2)}, {}, ScenarioError, "is not a range: both ends are 2"),
        ({MASS: (8, 4)}, {}, ScenarioError, "8 is more than 4, its upper end"),
        ({MASS: relative(0.1, -0.1)}, {}, ScenarioError, "0.1 is more than -0.1, its upper end"),
        ({"load.offset": relative(-1, 1)}, {}, ScenarioError, "is 0 in the scenario, so no percentage"),
        ({MASS: (1, 2)}, {"runs": 0}, ParameterError, "runs = 0: must be a whole number from 1"),
        ({MASS: (1, 2)}, {"runs": 2.5}, ParameterError, "runs = 2.5: must be a whole number from 1"),
        ({MASS: (1, 2)}, {"seed": -1}, ParameterError, "seed = -1: must be a whole number from 0"),
        ({}, {}, ParameterError, "must name a number that varies"),
    ],
)
def test_what_is_wrong_is_one_line(
    ranges: dict[str, Any], more: dict[str, Any], error: type[Exception], problem: str
) -> None:
    with pytest.raises(error, match=problem) as caught:
        draws(LOOP, ranges, **{"runs": 2, **more})
    assert "\n" not in str(caught.value)


def test_a_run_that_is_not_there_and_a_table_of_another_loop() -> None:
    table = simulate_batch(LOOP, {MASS: [6.0, 7.0]})
    for run in (-1, 2, 0.5):
        with pytest.raises(ParameterError, match=f"run = {run}: must be a whole number from 0 to 1"):
            run_of(LOOP, table, run)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="must be of this loop, with hash"):
        run_of(LOOP._replace(controller=example(TSMC)), table, 0)
