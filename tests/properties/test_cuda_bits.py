"""A thread of a CUDA device gives the bits of a single run, whatever the groups and chunks.

No device is needed: the PTX that a device would run is run by a machine in plain Python, and numba-cuda's own
simulator runs the text that the PTX is made from.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numba import cuda as numba_cuda

from hydroservo.engine import cuda, native
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from tests.support.cuda_cases import LOOPS, diverging, drawn, hexadecimal, jobs
from tests.support.ptx_machine import PtxDevice

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:valve.max_opening")]

ROOT = Path(__file__).parents[2]


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


@pytest.fixture(scope="module")
def simulated() -> dict[str, dict[str, list[str]]]:
    surroundings = os.environ | {"NUMBA_ENABLE_CUDASIM": "1"}
    command = [sys.executable, "-m", "tests.support.cuda_cases"]
    done = subprocess.run(command, cwd=ROOT, env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, list[str]]] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize("name", [*LOOPS, "diverging"])
def test_the_simulator_gives_the_bits_of_this_processor(
    name: str, simulated: dict[str, dict[str, list[str]]]
) -> None:
    assert simulated[name] == hexadecimal(simulate_batch(*jobs()[name], strict=True))


@pytest.mark.skipif(
    not (hasattr(numba_cuda, "PTXSource") and numba_cuda.is_available()),
    reason="numba-cuda or a CUDA device is missing",
)
@pytest.mark.parametrize("name", LOOPS)
def test_a_device_gives_the_bits_of_this_processor(name: str) -> None:
    parameters = drawn(300, 1)
    found = simulate_batch(LOOPS[name], parameters, strict=True, cuda=True)
    assert found.identical(simulate_batch(LOOPS[name], parameters, strict=True))
