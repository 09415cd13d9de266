"""A loop that runs again with other numbers, bit for bit as a run from nothing."""

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from hydroservo import HydroservoWarning, Loop, ParameterError, prepare_run, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.loop import AUTO, Simulation
from hydroservo.scenario import load_scenario
from hydroservo.testing.examples import example

SHORT = Simulation(duration=0.1, period=1e-3, substeps=10)
LOOP = example(Loop, simulation=SHORT, controller=PI(0.3, 100.0))
DESIGNED = load_scenario("laws/lq-sine", {"simulation.duration": "0.05 s"})
STEADY = load_scenario("axis/position", {"simulation.duration": "0.05 s"})
CHANGES = [
    (LOOP, {"plant.mass": 3.0, "controller.proportional_gain": 0.2}),
    (LOOP, {"plant.damping": 10}),
    (DESIGNED, {"plant.mass": 7.0, "simulation.seed": 5}),
    (STEADY, {"plant.friction.viscous": 900.0, "load.final": 300.0}),
]


def assert_same(trace: Any, data: xr.Dataset) -> None:
    """Every number of a run, and what it says of itself."""
    assert set(trace) == set(map(str, data.data_vars))
    for name in ("time", *trace):
        assert np.array_equal(np.asarray(trace[name]), data[name].to_numpy(), equal_nan=True), name
    assert trace.about == {name: said for name, said in data.attrs.items() if name != "warning"}


@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize(("loop", "changes"), CHANGES)
def test_it_has_the_bits_of_a_run_from_nothing(loop: Loop, changes: dict[str, Any], strict: bool) -> None:
    run = prepare_run(loop, strict=strict)
    substeps = {"simulation.substeps": run.loop.simulation.substeps}
    first = run(changes)
    for own, trace in ((changes, first), ({}, run({})), (changes, run(changes))):
        assert_same(trace, simulate(replace(loop, own | substeps), strict=strict))
    assert not np.array_equal(first["plant.velocity"], run({})["plant.velocity"])


def test_it_keeps_what_is_asked_for() -> None:
    run = prepare_run(LOOP, record=["plant.velocity"], metrics=())
    assert list(run({"plant.mass": 6.0})) == ["plant.velocity", "diverged", "diverged_at"]


def test_it_chooses_steps_and_warns_once() -> None:
    chosen = prepare_run(replace(LOOP, {"simulation.substeps": AUTO})).loop.simulation.substeps
    assert chosen == simulate(replace(LOOP, {"simulation.substeps": AUTO})).attrs["substeps"]
    with pytest.warns(HydroservoWarning, match="too coarse") as said:
        prepare_run(replace(LOOP, {"plant.bulk_modulus": 7e10, "simulation.substeps": 1}))({})
    assert len(said) == 1


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"plant.mass": -1.0}, "plant.mass = -1.0: must be a finite number above 0 [kg]"),
        ({"plant.mass": math.nan}, "plant.mass = nan: must be a finite number above 0 [kg]"),
        ({"plant.mass": "heavy"}, "plant.mass = ['heavy']: must be an array of numbers"),
        ({"plant.mass": PI(1.0, 1.0)}, "plant.mass = [PI"),
        ({"plant.mas": 5.0}, "parameters = 'plant.mas': no 'mas' there"),
        ({"simulation.duration": 1.0}, "must be a float outside simulation, hold and metrics, or the seed"),
        ({"controller": 5.0}, "must be a float outside simulation, hold and metrics, or the seed"),
        (5.0, "parameters = 5.0: must map paths to numbers"),
    ],
)
def test_a_bad_number_is_refused_in_one_line(changes: Any, says: str) -> None:
    run = prepare_run(LOOP)
    with pytest.raises(ParameterError) as refused:
        run(changes)
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
    assert_same(run({}), simulate(LOOP))


@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
def test_numbers_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"plant\.start_position"):
        prepare_run(STEADY)({"plant.start_position": 10.0})


@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")
def test_a_run_that_diverges_is_a_result() -> None:
    changes = {"plant.mass": 1e-300}
    trace = prepare_run(LOOP)(changes)
    assert trace["diverged"]
    assert_same(trace, simulate(replace(LOOP, changes)))


def test_what_is_no_loop_is_refused_at_once() -> None:
    with pytest.raises(ParameterError, match="must be a Loop"):
        prepare_run("paper/sine-pi")  # type: ignore[arg-type]
