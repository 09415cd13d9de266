"""A number that stops being finite is a divergence, and the result says which and when."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from hydroservo import Aim, Field, Loop, Simulation, ops, simulate, simulate_batch, tune
from hydroservo.control.controllers import PI
from hydroservo.core.block import leaves
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.sensors import NoPosition, RigSensors
from hydroservo.runs.kernels import first_loss, watched_paths
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example

PERIOD = 1e-3
MODES = pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])


class FailingState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "what is lost")]


class Failing(NamedTuple):
    """A law whose integral is nan from some sample on; its command shows nothing of it, but if asked to."""

    sample: float = 5.0
    shown: float = 0.0

    def init(self) -> FailingState:
        return FailingState(0.0, -1.0)

    def step(self, s: FailingState, y: Measurement, r: Demand, dt: float) -> FailingState:
        count = s.integral + 1.0
        integral = ops.where(count == self.sample, math.nan, count)
        return FailingState(ops.where(self.shown > 0.0, integral, 0.0), integral)


def loop(shown: float = 0.0) -> Loop:
    return example(Loop, Simulation(0.02, PERIOD, 4, record_period=PERIOD), controller=Failing(5.0, shown))


@MODES
@pytest.mark.parametrize(("shown", "path"), [(0.0, "controller.integral"), (1.0, "controller.u")])
def test_a_run_says_what_it_lost_and_when(compiled: bool, shown: float, path: str) -> None:
    data = simulate(loop(shown), compiled=compiled)
    assert bool(data["diverged"])
    assert data.attrs["diverged_by"] == path
    assert float(data["diverged_at"]) == 5 * PERIOD
    velocity, integral = data["plant.velocity"].values, data["controller.integral"].values
    assert np.isfinite(velocity[:6]).all()
    assert np.isnan(velocity[6:]).all()
    assert np.isfinite(integral).tolist() == [True] * 5 + [False] * 16


def test_each_run_of_a_batch_says_it() -> None:
    samples = np.array([5.0, 100.0, 0.0, 7.0])
    table = simulate_batch(loop(), {"controller.sample": samples})
    assert table["diverged"].values.tolist() == [True, False, True, True]
    assert table["diverged_by"].values.tolist() == [
        "controller.integral",
        "nothing",
        *["controller.integral"] * 2,
    ]
    assert table["diverged_at"].values == pytest.approx([5 * PERIOD, math.nan, 0.0, 7 * PERIOD], nan_ok=True)
    assert np.isfinite(table["rms_error"].values).all()


def test_tuning_does_not_choose_what_diverges() -> None:
    aim = Aim([loop()], [1.0])
    found = tune(aim, {"controller.sample": (0.0, 40.0)}, candidates=128)
    assert found.parameters["controller.sample"] > 20.0 or found.parameters["controller.sample"] % 1.0


def test_what_nothing_measures_may_stay_unknown() -> None:
    sensors = RigSensors(position=NoPosition())
    state = example(Loop, sensors=sensors).init()
    assert {"sensors.position.value"} & {path for path, value in leaves(state) if math.isnan(value)}
    assert "sensors.position.value" not in watched_paths(state)


def test_what_the_machine_loses_is_named_after_what_the_law_lost() -> None:
    state = example(Loop, controller=example(PI)).init()
    numbers = dict(leaves(state)) | {"plant.velocity": math.inf}
    watched = watched_paths(state)
    assert first_loss(state, watched, list(numbers.values()), 2.0) == ("plant.velocity", 2.0)
    for path in ("controller.u", "reference.value"):  # a law loses what its demand lost
        numbers[path] = math.nan
        assert first_loss(state, watched, list(numbers.values()), 2.0).path == path


def test_all_but_the_unknown_and_the_comparisons_are_watched() -> None:
    for name in scenarios():
        state = runnable_loop(load_scenario(name)).init()
        others = {path for path, _ in leaves(state)} - set(watched_paths(state))
        unknown = {path for path in others if not path.startswith("disturbance.")}
        assert all(math.isnan(value) for path, value in leaves(state) if path in unknown), name


def test_small_demands_do_not_make_a_run_diverge() -> None:
    data = simulate(load_scenario("rig/1khz-pi-square", {"reference.amplitude": "1 mm/s"}), record=[])
    assert float(data["max_error"]) > 10e-3
    assert not bool(data["diverged"])
