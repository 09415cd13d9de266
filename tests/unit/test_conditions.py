"""In what runs differ besides their controllers, and who is then called the best."""

from typing import Any

import pytest
import xarray as xr

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import DAC, PI, TSMC
from hydroservo.control.holds import DelayedHold, ZeroOrderHold
from hydroservo.control.references import Sine, Square
from hydroservo.control.wiring import wired
from hydroservo.core.time_series import TimeSeries
from hydroservo.machine.loads import Recorded
from hydroservo.machine.loads import Square as SquareLoad
from hydroservo.machine.valves import FirstOrderValve
from hydroservo.runs.comparison import MOST_LINES, differences, unequal_lines, winners
from hydroservo.testing.examples import example

LOOP = wired(example(Loop, Simulation(2e-3, 1e-4, 2, record_period=1e-4), controller=example(TSMC)))
RIVAL = LOOP._replace(controller=example(PI))


def run(loop: Loop) -> xr.Dataset:
    return simulate(loop, compiled=False)


@pytest.fixture(scope="module")
def tsmc() -> xr.Dataset:
    return run(LOOP)


@pytest.mark.parametrize(
    "other",
    [
        RIVAL,
        RIVAL._replace(controller=DAC(example(PI), 12, 5.0)),
        replace(LOOP, {"controller.power_gain_1": 0.0}),
        replace(RIVAL, {"simulation.record_period": 1e-3}),
        replace(LOOP, {"controller.model.plant.mass": 7.0}),
    ],
    ids=["law", "wrapper", "gain", "record", "belief"],
)
def test_runs_that_differ_in_their_controllers_are_equal(tsmc: xr.Dataset, other: Loop) -> None:
    runs = [tsmc, run(other)]
    assert differences(runs) == {}
    assert winners(runs)["rms_error"] in ({0}, {1})


@pytest.mark.parametrize(
    ("changes", "path", "values"),
    [
        ({"simulation.period": 2e-4}, "simulation.period", (1e-4, 2e-4)),
        ({"simulation.substeps": 4}, "simulation.substeps", (2, 4)),
        ({"simulation.seed": 1}, "simulation.seed", (0, 1)),
        ({"plant.mass": 7.0}, "plant.mass", (6.0, 7.0)),
        ({"valve.orifice.density": 900.0}, "valve.orifice.density", (850.0, 900.0)),
        ({"valve": example(FirstOrderValve)}, "valve", ("StaticValve", "FirstOrderValve")),
        ({"hold": DelayedHold(0.0)}, "hold", ("ZeroOrderHold", "DelayedHold")),
        ({"reference.amplitude": 0.02}, "reference.amplitude", (0.03, 0.02)),
        ({"reference": example(Square, 0.03)}, "reference", ("Sine", "Square")),
        ({"load": example(SquareLoad, 100.0)}, "load", ("Sine", "Square")),
    ],
    ids=lambda one: one if isinstance(one, str) else None,
)
def test_a_condition_that_differs_is_named_and_nobody_wins(
    tsmc: xr.Dataset, changes: dict[str, Any], path: str, values: tuple[Any, ...]
) -> None:
    runs = [tsmc, run(replace(RIVAL, changes))]
    assert differences(runs) == {path: values}
    assert not any(winners(runs).values())


def test_equal_numbers_in_blocks_of_two_types_are_no_equality() -> None:
    """NamedTuples of two types are equal where their numbers are."""
    sine, square = example(Loop).load, example(SquareLoad)
    assert ZeroOrderHold() == ()
    runs = [run(RIVAL._replace(load=sine)), run(RIVAL._replace(load=square)), run(RIVAL._replace(load=sine))]
    assert differences(runs) == {"load": ("Sine", "Square", "Sine")}


def test_recorded_signals_are_compared_by_their_samples() -> None:
    loads = [Recorded(TimeSeries.from_samples([0.0, 1.0, 2.0], [0.0, last, 0.0])) for last in (1.0, 1.0, 2.0)]
    one, same, other = (run(RIVAL._replace(load=load)) for load in loads)
    assert differences([one, same]) == {}
    assert list(differences([one, same, other])) == ["load.series.coefficients"]


def test_substeps_that_were_chosen_are_equal_if_the_question_was() -> None:
    auto = {"simulation.substeps": -1}
    runs = [run(replace(LOOP, auto)), run(replace(RIVAL, auto)).assign_attrs(substeps=64)]
    assert differences(runs) == {}


def test_estimates_of_two_models_are_not_ranked() -> None:
    believed = replace(LOOP, {"controller.model.plant.mass": 7.0})
    gains = replace(LOOP, {"controller.observer.linear_gain_1": 50.0})
    assert winners([run(LOOP), run(gains)])["estimate_rms_error_1"]
    assert winners([run(LOOP), run(believed)])["estimate_rms_error_1"] == set()


def test_lines_for_a_terminal() -> None:
    loops = [RIVAL, replace(RIVAL, {"simulation.period": 2e-4, "valve": example(FirstOrderValve)})]
    found = differences([run(loop) for loop in loops])
    first, *lines = unequal_lines(found, loops)
    assert "No run is marked best" in first.lead
    assert list(map(str, lines)) == [
        "  simulation.period: 100 µs, 200 µs",
        "  valve: StaticValve, FirstOrderValve",
    ]
    assert unequal_lines({}, loops) == []


def test_numbers_that_are_near_each_other_are_told_apart() -> None:
    (_, line) = unequal_lines({"plant.mass": (6.0, 6.0 + 2.0**-30)}, [RIVAL])
    assert str(line) == "  plant.mass: 6 kg, 6.0000000009313226 kg"


def test_many_differences_are_counted_by_table() -> None:
    many = {f"plant.{i}": (0.0, 1.0) for i in range(MOST_LINES)} | {"reference": ("Sine", "Square")}
    (_, line) = unequal_lines(many, [RIVAL, RIVAL._replace(reference=example(Sine))])
    assert str(line) == "  9 values in the tables plant (8), reference (1); --json lists them"
