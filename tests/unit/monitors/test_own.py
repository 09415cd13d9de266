"""A user's own monitor, one that is wrong, and the metrics of a batch."""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from hydroservo import LoopError, replace, simulate, simulate_batch
from hydroservo.control.monitors import ChamberPressures, Disturbance, RiseTime, StepResponse
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.signals import Demand
from hydroservo.scenario import load_plugin
from tests.support.monitors import SHORT
from tests.support.plugins import METRIC


@pytest.mark.parametrize("compiled", [False, True])
def test_a_users_own_monitor(tmp_path: Path, compiled: bool) -> None:
    path = tmp_path / "my_metric.py"
    path.write_text(METRIC, encoding="utf-8")
    own = next(cls for cls in load_plugin(path) if cls.__name__ == "ZeroCrossings")
    loop = replace(SHORT, {"simulation.substeps": 1, "reference.period": 0.02})
    data = simulate(loop, metrics={"crossings": own()}, compiled=compiled)
    error = (data["plant.velocity"] - data["reference.value"]).values
    expected = np.sum(error[1:] * error[:-1] < 0.0)
    assert expected > 2
    assert float(data["zero_crossings"]) == expected
    heard = np.r_[0.0, 0.0, np.cumsum(error[1:] * error[:-1] < 0.0)[:-1]]  # before each sample
    assert data["crossings.count"].values.tolist() == heard.tolist()
    assert data["zero_crossings"].attrs["better"] == "smaller"
    assert "rms_error" not in data


class Two(NamedTuple):
    first: Annotated[float, Field("m", "the first")]
    second: Any = 0.0


def wrong(after: Any = Two(1.0), result: Any = Two(1.0)) -> Block:  # noqa: B008
    """A monitor that does not do what it should."""

    @role(Monitor)
    class Wrong(NamedTuple):
        def init(self) -> Two:
            return Two(0.0)

        def step(self, m: Any, loop: Block, s: Block, t: float, dt: float) -> Any:
            return after

        def values(self, m: Any) -> Any:
            return result

    return Wrong()


@pytest.mark.parametrize(
    ("monitor", "problem"),
    [
        (ChamberPressures(), r"the metric mine \(ChamberPressures\) does not fit this loop: .*pressure_a"),
        (Disturbance(), r"the metric mine \(Disturbance\) does not fit this loop"),
        (wrong(after=Demand(0.0, 0.0, 0.0)), "the metric mine: a step must return a state of init's type"),
        (wrong(after=Two(1.0, 2)), "the metric mine: a step must return a state of init's type, with floats"),
        (wrong(result=Two(1.0, "many")), "the metric mine: values must be a NamedTuple of floats and flags"),
        (wrong(result=2.0), "the metric mine: values must be a NamedTuple of floats and flags"),
    ],
)
def test_a_monitor_that_does_not_fit_is_said_in_one_line(monitor: Block, problem: str) -> None:
    with pytest.raises(LoopError, match=problem) as caught:
        simulate(SHORT, metrics={"mine": monitor})
    assert "\n" not in str(caught.value)


def test_a_batch_has_the_metrics_that_are_asked_for() -> None:
    table = simulate_batch(SHORT, {"plant.mass": [5.0, 6.0]}, metrics=[RiseTime(), StepResponse()])
    assert isinstance(table, xr.Dataset)
    found = [str(name) for name, one in table.data_vars.items() if one.attrs.get("kind") == "metric"]
    steps = ["settling_time", "overshoot", "demand_reach", "demand_jumps"]
    assert found == ["rise_time", *steps, "diverged", "diverged_at"]
