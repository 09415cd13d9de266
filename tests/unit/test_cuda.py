"""PTX, and what a CUDA device is asked for; the bits are in the properties."""

import gc
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from hydroservo import Loop, LoopError, ParameterError, Simulation
from hydroservo.control.controllers import PI, TSMC, Backstepping
from hydroservo.core.block import Block
from hydroservo.engine import cuda, cuda_driver, flat
from hydroservo.engine.cuda import GOING, NAME, THREADS, ptx
from hydroservo.engine.cuda_driver import DeviceKernel, DeviceMemory
from hydroservo.engine.native import CompileError, MachineCode
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.fitting import first_state
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.examples import example
from tests.support.ptx_machine import PtxDriver, Status

pytestmark = pytest.mark.nightly

LOOP = example(Loop, Simulation(0.002, 1e-4))
MASSES = {"plant.mass": np.linspace(4.0, 8.0, 3)}


LAWS = [PI, Backstepping, TSMC]


@pytest.fixture
def driver(monkeypatch: pytest.MonkeyPatch) -> PtxDriver:
    return PtxDriver().installed(monkeypatch)


def ptx_of(law: Any, strict: bool) -> str:
    """The PTX of a loop's kernel."""
    loop = runnable_loop(LOOP._replace(controller=example(law)))
    with pytest.MonkeyPatch.context() as patch:
        driver = PtxDriver().installed(patch)
        batch.group_kernel(loop, first_state(loop), 21, ("plant.mass",), strict, True)
    return driver.loaded[0]


def count(text: str, operations: str, ending: str) -> int:
    return len(re.findall(rf"\s(?:{operations}){re.escape(ending)}\s", text))


@pytest.mark.parametrize("law", LAWS)
def test_a_strict_kernel_rounds_each_operation(law: Any) -> None:
    text = ptx_of(law, strict=True)
    assert count(text, "add|sub|mul", ".rn.f64") > 100
    assert count(text, "add|sub|mul", ".f64") == 0
    assert "fma" not in text


def test_another_kernel_may_fuse_operations() -> None:
    text = ptx_of(PI, strict=False)
    assert count(text, "fma", ".rn.f64") > 100
    assert count(text, "add|sub|mul", ".rn.f64") == 0


def test_the_ptx_needs_nothing_from_outside() -> None:
    text = ptx_of(TSMC, strict=False)
    assert text.count(f".visible .entry {NAME}(") == 1
    assert not re.search(r"\.extern|\scall|^\.global", text, re.MULTILINE)


def thread(compute: Callable[[float], float]) -> Callable[..., int]:
    """A function with the arguments of a kernel that computes something from dt."""

    def advance(constants, tables, memory, runs, thread, first, last, dt):  # type: ignore[no-untyped-def]
        return int(compute(dt))

    for function in (compute, advance):
        function.__module__ = flat.__name__  # whose functions may use memory
    return advance


def remainder(x: float) -> float:
    return x % 0.3


def same(x: float) -> float:
    return x


def test_a_function_that_no_device_has_is_named() -> None:
    with pytest.raises(CompileError, match="it calls fmod, which no CUDA device has"):
        ptx(thread(remainder), 1, strict=True)


def outcome(driver: PtxDriver, made: MachineCode, dt: float) -> int:
    """What becomes of the one run of a kernel."""
    going = DeviceMemory(np.array([GOING]))
    whole = np.array([0, 0, going.address, 1, 0, 1])
    arguments = [np.zeros(1), *(whole[i : i + 1] for i in range(whole.size)), np.array([dt])]
    DeviceKernel(made.code, made.name).launch(1, THREADS, arguments)
    return int(going.read()[0])


def test_what_a_thread_gives_is_told(driver: PtxDriver) -> None:
    assert outcome(driver, ptx(thread(same), 1, strict=True), 42.0) == 42


def test_more_numbers_than_a_device_takes_are_refused() -> None:
    with pytest.raises(CompileError, match="a CUDA device takes 500 numbers of blocks, and these have 501"):
        ptx(thread(same), 501, strict=True)


class Heard(NamedTuple):
    samples: float


class Picky(NamedTuple):
    """A monitor that reads beyond its array at the second sample."""

    knots: np.ndarray = np.zeros(1)

    def init(self) -> Heard:
        return Heard(0.0)

    def step(self, m: Heard, loop: Block, s: Block, t: float, dt: float) -> Heard:
        i = 0
        while i < m.samples:
            i += 1
        return Heard(m.samples + 1.0 + float(self.knots[i]))

    def values(self, m: Heard) -> Heard:
        return m


def test_a_group_stops_where_a_block_raised(driver: PtxDriver) -> None:
    with pytest.raises(LoopError, match="a block raised an exception"):
        simulate_batch(LOOP, MASSES, metrics=[Picky()], strict=True, cuda=True)


def test_memory_is_freed_and_the_kernel_stays(driver: PtxDriver) -> None:
    first = simulate_batch(LOOP, MASSES, strict=True, cuda=True)
    assert simulate_batch(LOOP, MASSES, strict=True, cuda=True).identical(first)
    gc.collect()
    assert driver.memory == {}
    assert len(driver.loaded) == 1


@pytest.mark.parametrize(("spilled", "registers"), [(1200, ["128"]), (1201, ["128", "255"])])
def test_a_large_law_takes_all_registers(spilled: int, registers: list[str], driver: PtxDriver) -> None:
    driver.SPILLED = spilled
    simulate_batch(LOOP, MASSES, strict=True, cuda=True)
    assert re.findall(r"\.maxnreg (\d+)", "".join(driver.loaded)) == registers


def test_progress_rises_within_groups(driver: PtxDriver, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DeviceKernel, "resident", lambda *_: 2)
    monkeypatch.setattr(cuda, "WAVES", 1)
    monkeypatch.setattr(batch, "CUDA_CHUNK", 7)
    seen: list[float] = []
    simulate_batch(LOOP, MASSES, strict=True, cuda=True, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[0] == pytest.approx(7 / 21 * 2 / 3)
    assert seen[-1] == 1.0


def no_library(_flags: int) -> None:
    raise RuntimeError("libcuda.so cannot be found")


NO_DEVICE = "cuda = True: the CUDA driver says CUDA_ERROR_NO_DEVICE"


@pytest.mark.parametrize(
    ("call", "answer", "said"),
    [
        ("cuInit", no_library, "cuda = True: there is no driver of a CUDA device"),
        ("cuInit", lambda _: (Status.CUDA_ERROR_NO_DEVICE,), NO_DEVICE),
        ("cuDeviceGet", lambda _: (Status.CUDA_ERROR_NO_DEVICE, None), NO_DEVICE),
        (
            "cuMemAlloc",
            lambda _: (Status.CUDA_ERROR_OUT_OF_MEMORY, None),
            "cuda = True: the CUDA driver says CUDA_ERROR_OUT_OF_MEMORY",
        ),
    ],
)
def test_what_is_missing_is_said_in_one_line(call: str, answer: Any, said: str, driver: PtxDriver) -> None:
    setattr(driver, call, answer)
    with pytest.raises(ParameterError, match=rf"^{re.escape(said)}$"):
        simulate_batch(LOOP, MASSES, cuda=True)


def test_missing_bindings_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    cuda_driver.device.cache_clear()
    monkeypatch.setattr(cuda_driver, "driver", None)
    said = "cuda = True: cuda-bindings is missing; pip install 'hydroservo[cuda]' brings it"
    with pytest.raises(ParameterError, match=rf"^{re.escape(said)}$"):
        simulate_batch(LOOP, MASSES, cuda=True)
