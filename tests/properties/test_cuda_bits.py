"""A thread of a CUDA device gives the bits of a single run, whatever the groups and chunks.

No device is needed: the PTX that a device would run is run by a machine in plain Python.
"""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hydroservo.engine import cuda
from hydroservo.engine.cuda_driver import DeviceKernel, has_device
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from tests.support.cuda_cases import LOOPS, diverging, drawn
from tests.support.ptx_machine import PtxDriver
from tests.support.tiers import mostly

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:valve.max_opening")]


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> None:
    PtxDriver().installed(monkeypatch)


@pytest.mark.usefixtures("device")
@pytest.mark.parametrize("name", mostly(pytest.mark.nightly, LOOPS, [*LOOPS][:1]))
@settings(max_examples=3, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    runs=st.integers(1, 5), most=st.integers(1, 5), chunk=st.integers(1, 20), seed=st.integers(0, 2**32 - 1)
)
def test_strict_ptx_gives_the_bits_of_this_processor(
    name: str, runs: int, most: int, chunk: int, seed: int
) -> None:
    parameters = drawn(runs, seed)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(DeviceKernel, "resident", lambda *_: most)
        patch.setattr(cuda, "WAVES", 1)
        patch.setattr(batch, "CUDA_CHUNK", chunk)
        found = simulate_batch(LOOPS[name], parameters, strict=True, cuda=True)
    assert found.identical(simulate_batch(LOOPS[name], parameters, strict=True))


@pytest.mark.usefixtures("device")
def test_a_thread_whose_run_diverges_stops_there() -> None:
    loop, parameters = diverging()
    found = simulate_batch(loop, parameters, strict=True, cuda=True)
    assert found["diverged"].values.tolist() == [False, True, False]
    assert found.identical(simulate_batch(loop, parameters, strict=True))


@pytest.mark.skipif(not has_device(), reason="there is no CUDA device")
@pytest.mark.parametrize("name", LOOPS)
def test_a_device_gives_the_bits_of_this_processor(name: str) -> None:
    parameters = drawn(300, 1)
    found = simulate_batch(LOOPS[name], parameters, strict=True, cuda=True)
    assert found.identical(simulate_batch(LOOPS[name], parameters, strict=True))
