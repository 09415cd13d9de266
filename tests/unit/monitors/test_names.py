"""What monitors and metrics are called, and which monitors a loop has."""

import pickle
from typing import Any, NamedTuple

import pytest

from hydroservo import Loop, LoopError, ParameterError, monitors, replace, simulate
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.metrics import METRIC_FIELDS, declared_metrics, monitors_of, usual
from hydroservo.control.monitors import ChamberPressures, Energy, RiseTime, StepResponse
from hydroservo.control.monitors.group import named
from hydroservo.core.group import group
from hydroservo.machine.plants import Cylinder
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block
from tests.support.monitors import SHORT

unpickled = pickle.loads  # of what is pickled here


def test_each_metric_of_hydroservo_has_a_name_of_its_own() -> None:
    own = [one.values(one.init())._fields for one in (getattr(monitors, name)() for name in monitors.__all__)]
    assert list(METRIC_FIELDS) == [name for names in own for name in names] + ["diverged", "diverged_at"]
    assert all(field.meaning for field in METRIC_FIELDS.values())


def test_monitors_are_called_after_their_classes() -> None:
    found = named([ChamberPressures(), StepResponse(), StepResponse(0.01), ChamberPressures(1e5)])
    assert list(found) == ["chamber_pressures", "step_response", "step_response_2", "chamber_pressures_2"]
    assert named({"mine": RiseTime()}) == {"mine": RiseTime()}
    assert named(()) == {}


def test_a_metric_that_another_gives_already_has_its_monitors_name_before_it() -> None:
    watching = {"loose": StepResponse(0.2), "tight": StepResponse(0.01), "rise": RiseTime()}
    assert list(declared_metrics(watching)) == [
        *("settling_time", "overshoot", "demand_reach", "demand_jumps"),
        *("tight_settling_time", "tight_overshoot", "tight_demand_reach", "tight_demand_jumps", "rise_time"),
        *("diverged", "diverged_at"),
    ]


@pytest.mark.parametrize(
    ("metrics", "problem"),
    [
        (StepResponse(), "metrics = StepResponse(band=0.05): must be a list of monitors"),
        ("rise", "metrics = 'rise': must be a list of monitors"),
        ([StepResponse], "must be a monitor: a block with init, step and values"),
        ([example(PI)], "must be a monitor: a block with init, step and values"),
        (
            {"rise time": RiseTime()},
            "metrics = 'rise time': must be a name of letters, digits and underscores",
        ),
        ({"_rise": RiseTime()}, "metrics = '_rise': must be a name of letters, digits and underscores"),
        ([RiseTime(low=2.0)], "low = 2"),
    ],
)
def test_what_is_no_monitor_is_refused(metrics: Any, problem: str) -> None:
    with pytest.raises(ParameterError) as caught:
        simulate(SHORT, metrics=metrics)
    assert problem in str(caught.value)


def test_a_group_is_a_block_that_pickles() -> None:
    made = group({"first": StepResponse(0.01), "second": Energy()})
    assert made.first.band == 0.01
    assert type(made) is type(group({"first": Energy(), "second": Energy()}))
    loop = example(Loop, metrics=made)
    assert unpickled(pickle.dumps(loop)) == loop
    assert type(unpickled(pickle.dumps(made))) is type(made)
    assert_same_block(replace(loop, {"metrics.first.band": 0.5}).metrics.first, StepResponse(0.5))


def test_the_usual_monitors_are_those_that_the_loop_has_signals_for() -> None:
    always = ["tracking_error", "step_response", "oscillation", "command_effort", "piston_travel"]
    assert list(usual(example(Loop))) == always
    assert list(usual(example(Loop, plant=example(Cylinder)))) == [*always, "chamber_pressures"]
    assert sorted(usual(example(Loop, controller=example(TSMC)))) == sorted([*always, "disturbance"])
    assert monitors_of(example(Loop, metrics=group({"energy": Energy()}))) == {"energy": Energy()}


class Nameless(NamedTuple):
    """A monitor whose values are no record."""

    broken: bool = False

    def init(self) -> Any:
        return 0.0

    def step(self, m: Any, loop: Any, s: Any, t: float, dt: float) -> Any:
        return m

    def values(self, m: Any) -> Any:
        return m.work if self.broken else {"work": 1.0}


@pytest.mark.parametrize(
    ("monitor", "says"),
    [
        (Nameless(), "the metric mine: values must be a NamedTuple of floats and flags"),
        (
            Nameless(broken=True),
            "the metric mine (Nameless) gives no values at the start: 'float'",
        ),
    ],
)
def test_a_monitor_without_values_is_one_line_wherever_metrics_are_asked_for(monitor: Any, says: str) -> None:
    with pytest.raises(LoopError) as error:
        declared_metrics({"mine": monitor})
    assert str(error.value).startswith(says)
