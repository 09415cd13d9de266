"""Test vectors of exports: what they hold of the simulation."""

import numpy as np
import pytest

from hydroservo.control.loop import Loop
from hydroservo.export.unit import CModule, Part
from hydroservo.export.vectors import HUGE, Vectors
from hydroservo.runs.run import simulate
from tests.support.export.projects import scenario, unit


def test_vectors_begin_as_the_simulation_does(loop: Loop, law: tuple[CModule, Vectors]) -> None:
    data = simulate(scenario(simulation__record_period=1e-5), strict=True)
    for column, signal in enumerate(law[0].states):
        np.testing.assert_array_equal(law[1].expected[:50, column], data[signal.path].values[:50])
    for i, start in enumerate(np.linspace(0, 5001 - 50, 10).round().astype(int)):
        seen = law[1].inputs[50 * i : 50 * i + 50]
        np.testing.assert_array_equal(seen[:, 0], data["plant.velocity"].values[start : start + 50])
        np.testing.assert_array_equal(seen[:, 2], data["reference.value"].values[start : start + 50])


def test_vectors_hold_the_command_that_was_applied() -> None:
    changes = {"hold__type": "DelayedHold", "hold__delay": 5e-6, "simulation__substeps": 2}
    u = simulate(scenario(simulation__record_period=1e-5, **changes), strict=True)["controller.u"].values
    found = unit(scenario(**changes))[1].inputs[100:150, 1]
    start = round(2 * (5001 - 50) / 9)
    np.testing.assert_array_equal(found, (0.5 * u[:-1] + 0.5 * u[1:])[start - 2 :][:50])


def test_a_machine_is_given_the_loops_commands(loop: Loop) -> None:
    made, vectors = unit(loop, Part.MACHINE)
    data = simulate(scenario(simulation__record_period=1e-5), strict=True)
    np.testing.assert_array_equal(vectors.inputs[:50, 0], data["controller.u"].values[:50])
    velocity = [signal.path for signal in made.states].index("plant.velocity")
    np.testing.assert_array_equal(vectors.expected[:50, velocity], data["plant.velocity"].values[1:51])


def test_bad_samples_come_last_in_double_alone(
    law: tuple[CModule, Vectors], single: tuple[CModule, Vectors]
) -> None:
    inputs, expected = law[1].inputs, law[1].expected
    np.testing.assert_array_equal(inputs[:500], single[1].inputs)
    assert np.isnan(inputs[500]).tolist() == [True, False, False]
    assert inputs[521].tolist() == [HUGE] * 3
    assert np.isfinite(inputs[501:]).all()
    np.testing.assert_array_equal(inputs[522:], inputs[480:500])
    assert expected[500].tolist() == [signal.value for signal in law[0].states]
    assert np.isfinite(expected).all()


@pytest.mark.parametrize("substeps", [1, "auto"])
def test_a_short_scenario_gives_all_its_samples(substeps: object) -> None:
    short = scenario(simulation__duration=1e-3, simulation__substeps=substeps)
    assert len(unit(short)[1].inputs) == 101 + 42
