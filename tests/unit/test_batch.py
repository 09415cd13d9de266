"""The face of simulate_batch; its bits are in the properties."""

from typing import Any

import numpy as np
import pytest

from hydroservo import Loop, LoopError, ParameterError, Simulation
from hydroservo.control.metrics import declared_metrics, usual
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.provenance import scenario_hash
from hydroservo.testing.examples import example

LOOP = example(Loop, Simulation(0.002, 1e-4))
MASSES = np.linspace(4.0, 8.0, 70)


def test_a_table_of_metrics_with_units_and_provenance() -> None:
    table = simulate_batch(LOOP, {"plant.mass": MASSES, "controller.integral_gain": np.zeros(70)})
    assert dict(table.sizes) == {"run": 70}
    assert set(declared_metrics(usual(LOOP))) < set(table.data_vars)
    assert np.array_equal(table["plant.mass"], MASSES)
    assert table["plant.mass"].attrs["units"] == "kg"
    assert table["rms_error"].attrs["units"] == "m/s"
    assert table["diverged"].dtype == bool
    assert table.attrs["hash"] == scenario_hash(LOOP)


def test_progress_rises_to_one() -> None:
    seen: list[float] = []
    simulate_batch(LOOP, {"plant.mass": MASSES}, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) == 3


def test_an_interrupt_stops_the_batch() -> None:
    def interrupt(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_batch(LOOP, {"plant.mass": np.full(2000, 6.0)}, progress=interrupt)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({}, "must name at least one parameter"),
        ({"plant.mss": MASSES}, "no 'mss' there"),
        ({"plant": MASSES}, "must be a float outside simulation, hold and metrics, or the seed"),
        ({"simulation.period": MASSES}, "must be a float outside simulation, hold and metrics, or the seed"),
        ({"plant.mass": [1.0, -2.0, 3.0]}, r"plant.mass = -2.0: must be a finite number above 0 \[kg\]"),
        ({"plant.mass": [1.0, float("nan")]}, "plant.mass = nan: must be a finite number"),
        ({"plant.mass": []}, r"must be an array of shape \(runs,\)"),
        ({"plant.mass": [[1.0]]}, r"must be an array of shape \(runs,\)"),
        ({"plant.mass": [1.0], "plant.damping": [1.0, 2.0]}, "must be arrays of one length"),
        ({"plant.mass": ["heavy"]}, "must be an array of numbers"),
    ],
)
def test_wrong_parameters_are_named_in_one_line(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message) as caught:
        simulate_batch(LOOP, parameters)
    assert "\n" not in str(caught.value)


def test_a_controller_that_does_not_fit_is_refused() -> None:
    with pytest.raises(LoopError):
        simulate_batch(LOOP._replace(controller=LOOP.plant), {"plant.mass": MASSES})  # type: ignore[arg-type]
