"""Monitors change no run, and give the same bits in every way of running."""

import numpy as np
import pytest

from hydroservo import monitors, replace, simulate, simulate_batch
from hydroservo.control.metrics import METRIC_FIELDS
from hydroservo.core.block import Block
from hydroservo.machine.integrators import RK4, Rosenbrock, Tsit5
from hydroservo.testing.examples import example
from tests.support.monitors import FULL

EVERY = [example(getattr(monitors, name)) for name in monitors.__all__]


@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_to_hear_of_the_steps_changes_none(integrator: Block) -> None:
    loop = replace(FULL, {"simulation.integrator": integrator})
    with_all, with_none = (simulate(loop, metrics=one, compiled=False) for one in (EVERY, ()))
    assert set(with_none.data_vars) - set(with_all.data_vars) == set()
    for name in with_none.data_vars:
        assert with_none[name].identical(with_all[name]), name


@pytest.mark.slow
@pytest.mark.parametrize("integrator", [RK4(), Rosenbrock(), Tsit5()])
def test_each_way_of_running_gives_the_same_bits(integrator: Block) -> None:
    loop = replace(FULL, {"simulation.integrator": integrator})
    interpreted = simulate(loop, metrics=EVERY, compiled=False)
    compiled = simulate(loop, metrics=EVERY, strict=True)
    assert compiled.identical(interpreted)
    assert not bool(compiled["diverged"])
    masses = np.array([5.0, loop.plant.mechanism.mass, 9.0])
    table = simulate_batch(loop, {"plant.mechanism.mass": masses}, metrics=EVERY, strict=True)
    for name in METRIC_FIELDS:
        assert table[name].values[1].tobytes() == interpreted[name].values.tobytes(), name
