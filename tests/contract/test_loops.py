"""Whole loops of any blocks: interpreted and compiled runs are the same to the last bit."""

from typing import get_type_hints

import numpy as np
import pytest
import xarray as xr
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.holds import DelayedHold
from hydroservo.core.errors import ParameterError
from hydroservo.runs.cautions.records import check_records
from hydroservo.runs.run import runnable_loop
from hydroservo.scenario.role_checks import ROLES
from hydroservo.testing.drawing import ORDINARY
from tests.support.strategies import wired

PERIODS = 200

SIMULATIONS = st.builds(
    lambda period, substeps, stride: Simulation(PERIODS * period, period, substeps, stride * period),
    period=st.sampled_from([1e-5, 1e-4]),
    substeps=st.integers(1, 3),
    stride=st.sampled_from([1, 7, PERIODS]),
)


def signs(result: xr.Dataset) -> list[np.ndarray]:
    """The signs of all numbers, which tell 0 from -0."""
    return [np.signbit(one.values) & (one.values == one.values) for one in result.data_vars.values()]


def runs(loop: Loop) -> bool:
    """False where drawn numbers do not go together, as noises without a filter, or a record is unseen."""
    try:
        check_records(loop)
        runnable_loop(loop)
    except ParameterError:
        return False
    return True


@pytest.mark.filterwarnings("ignore::hydroservo.HydroservoWarning")  # of drawn loops something is always said
@pytest.mark.slow
@settings(max_examples=12, phases=[Phase.explicit, Phase.reuse, Phase.generate])  # each compiles a loop
@given(loop=st.deferred(lambda: wired(Loop, ORDINARY)), simulation=SIMULATIONS)
def test_compiled_equals_interpreted(loop: Loop, simulation: Simulation) -> None:
    loop = replace(loop, {"simulation": simulation})
    if isinstance(loop.hold, DelayedHold):
        half, even = 0.5 * simulation.period, 2 * simulation.substeps
        loop = replace(loop, {"hold.delay": half, "simulation.substeps": even})
    assume(runs(loop))
    compiled, interpreted = simulate(loop, strict=True), simulate(loop, compiled=False)
    assert compiled.identical(interpreted)
    assert all(np.array_equal(a, b) for a, b in zip(signs(compiled), signs(interpreted), strict=True))


def test_each_exchangeable_block_is_drawn() -> None:
    hints = get_type_hints(Loop)
    drawn = {name for name in Loop._fields if hints[name] in ROLES}
    assert drawn == {
        "plant",
        "valve",
        "supply",
        "load",
        "sensors",
        "start",
        "reference",
        "controller",
        "controls",
        "drive",
        "hold",
    }
