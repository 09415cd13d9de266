"""A thread of a CUDA device gives the bits of a single run, whatever the groups and chunks.

No device is needed: the PTX that a device would run is run by a machine in plain Python, and numba-cuda's own
simulator runs the text that the PTX is made from.
"""

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numba import cuda as numba_cuda

from hydroservo import Loop, Simulation, monitors
from hydroservo.controllers import DAC, PI, TSMC, AntiWindup, Backstepping, RateLimit
from hydroservo.engine import cuda, native
from hydroservo.holds import DelayedHold
from hydroservo.integrators import Tsit5
from hydroservo.loads import Recorded as RecordedLoad
from hydroservo.loads import Square as SquareLoad
from hydroservo.monitors.group import group
from hydroservo.observers import Explicit, Implicit, ModelDerivative, TSMObserver
from hydroservo.references import Chirp, Multisine, Recorded, Square
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from hydroservo.sensors import DelayedSensors, Dropout, ExactDifferentiator, NoisySensors, RigSensors
from hydroservo.testing.examples import example
from hydroservo.time_series import TimeSeries
from hydroservo.valves import FirstOrderValve, StaticValve
from ptx_machine import PtxDevice

pytestmark = pytest.mark.slow

PRESSURES = "ChamberPressures"  # a cylinder's, whose parameters have other names
TIME = np.linspace(0.0, 2e-3, 6)
LOOPS = {
    "tsmc": example(
        Loop,
        Simulation(1e-3, 1e-4, 2),
        controller=example(TSMC, observer=example(TSMObserver, realisation=Implicit())),
    ),
    "tsmc-explicit": example(
        Loop,
        Simulation(1e-3, 1e-4),
        reference=example(Multisine),
        controller=example(
            TSMC, observer=example(TSMObserver, realisation=Explicit()), derivative=ModelDerivative()
        ),
    ),
    "backstepping-recorded": example(
        Loop,
        Simulation(2e-3, 2e-4),
        reference=Recorded(TimeSeries.from_samples(TIME, 0.03 * np.sin(1e3 * TIME))),
        load=RecordedLoad(TimeSeries.from_samples(TIME[[0, 2, 5]], 1e6 * TIME[[0, 2, 5]])),
        controller=example(Backstepping),
    ),
    "pi-noise": example(
        Loop,
        Simulation(1e-3, 1e-4),
        valve=example(FirstOrderValve),
        sensors=example(NoisySensors),
        reference=example(Square),
        controller=example(PI),
    ),
    "rig": example(
        Loop,
        Simulation(1e-3, 1e-4, 2),
        sensors=Dropout(0.3, DelayedSensors(example(RigSensors, velocity=example(ExactDifferentiator)))),
        controller=example(AntiWindup, DAC(example(RateLimit, example(PI)))),
        hold=DelayedHold(5e-5),
    ),
    "tsit5": example(
        Loop,
        Simulation(6e-4, 1e-4, integrator=Tsit5(1e-6)),
        load=example(SquareLoad, period=3e-4),
        reference=example(Chirp),
        controller=example(PI),
    ),
    "every-metric": example(
        Loop,
        Simulation(4e-4, 1e-4, 2),
        reference=example(Square, period=3e-4),
        controller=example(TSMC),
        metrics=group({name: getattr(monitors, name)() for name in monitors.__all__ if name != PRESSURES}),
    ),
}
RANGES = {
    "plant.bulk_modulus": (3e8, 2e9),
    "plant.start_position": (0.0, 0.078),
    "controller.saturation.limit": (1e-3, 10.0),
}


def drawn(runs: int, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    seeds = rng.integers(0, 2**53, runs, endpoint=False)
    return {path: rng.uniform(*limits, runs) for path, limits in RANGES.items()} | {"simulation.seed": seeds}


def diverging() -> tuple[Loop, dict[str, Any]]:
    """A loop and parameters of which the second makes its run diverge."""
    loop = example(
        Loop, Simulation(1e-3, 1e-4), valve=example(StaticValve, max_opening=1e300), reference=example(Square)
    )
    gains, limits = np.array([100.0, 1e308, 90.0]), np.full(3, 1e300)
    return loop, {"controller.proportional_gain": gains, "controller.saturation.limit": limits}


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "READY", {})
    monkeypatch.setattr(cuda, "cuda", PtxDevice())


@pytest.mark.usefixtures("device")
@pytest.mark.parametrize("name", LOOPS)
@settings(max_examples=3, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    runs=st.integers(1, 5), most=st.integers(1, 5), chunk=st.integers(1, 20), seed=st.integers(0, 2**32 - 1)
)
def test_strict_ptx_gives_the_bits_of_this_processor(
    name: str, runs: int, most: int, chunk: int, seed: int
) -> None:
    parameters = drawn(runs, seed)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cuda, "MOST", most)
        patch.setattr(batch, "CUDA_CHUNK", chunk)
        found = simulate_batch(LOOPS[name], parameters, strict=True, cuda=True)
    assert found.identical(simulate_batch(LOOPS[name], parameters, strict=True))


@pytest.mark.usefixtures("device")
def test_a_thread_whose_run_diverges_stops_there() -> None:
    loop, parameters = diverging()
    found = simulate_batch(loop, parameters, strict=True, cuda=True)
    assert found["diverged"].values.tolist() == [False, True, False]
    assert found.identical(simulate_batch(loop, parameters, strict=True))


SIMULATED = """
import json, sys
import numpy as np
import test_cuda_bits as cases
from hydroservo import batch
from hydroservo.engine import cuda

cuda.MOST, batch.CUDA_CHUNK = 3, 4
jobs = {name: (loop, cases.drawn(4, 7)) for name, loop in cases.LOOPS.items()}
jobs["diverging"] = cases.diverging()
tables = {name: batch.simulate_batch(*job, strict=True, cuda=True) for name, job in jobs.items()}
json.dump({name: cases.hexadecimal(table) for name, table in tables.items()}, sys.stdout)
"""


def hexadecimal(table: xr.Dataset) -> dict[str, list[str]]:
    """Every number of a table, to the last bit."""
    return {
        str(name): [float(x).hex() for x in values.values]
        for name, values in table.drop_vars("diverged_by").items()
    }


@pytest.fixture(scope="module")
def simulated() -> dict[str, dict[str, list[str]]]:
    here = os.path.dirname(__file__)  # noqa: PTH120
    surroundings = os.environ | {
        "NUMBA_ENABLE_CUDASIM": "1",
        "PYTHONPATH": os.pathsep.join([here, os.path.dirname(here)]),  # noqa: PTH120
    }
    command = [sys.executable, "-c", SIMULATED]
    done = subprocess.run(command, env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, list[str]]] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize("name", [*LOOPS, "diverging"])
def test_the_simulator_gives_the_bits_of_this_processor(
    name: str, simulated: dict[str, dict[str, list[str]]]
) -> None:
    loop, parameters = diverging() if name == "diverging" else (LOOPS[name], drawn(4, 7))
    assert simulated[name] == hexadecimal(simulate_batch(loop, parameters, strict=True))


@pytest.mark.skipif(
    not (hasattr(numba_cuda, "PTXSource") and numba_cuda.is_available()),
    reason="numba-cuda or a CUDA device is missing",
)
@pytest.mark.parametrize("name", LOOPS)
def test_a_device_gives_the_bits_of_this_processor(name: str) -> None:
    parameters = drawn(300, 1)
    found = simulate_batch(LOOPS[name], parameters, strict=True, cuda=True)
    assert found.identical(simulate_batch(LOOPS[name], parameters, strict=True))
