"""PTX, and what a CUDA device is asked for; the bits are in the properties."""

import math
import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import cuda as numba_cuda
from numba import types

from hydroservo import Loop, LoopError, ParameterError, Simulation
from hydroservo.controllers import PI, TSMC, Backstepping
from hydroservo.engine import cuda, native
from hydroservo.engine.native import CompileError, MachineCode
from hydroservo.engine.ptx import NAME, RAISED, ptx
from hydroservo.runs import batch
from hydroservo.runs.batch import simulate_batch
from hydroservo.runs.fitting import first_state
from hydroservo.runs.run import ready
from hydroservo.testing.examples import example
from tests.support.ptx_machine import PtxDevice, PtxFunction

pytestmark = pytest.mark.slow

LOOP = example(Loop, Simulation(0.002, 1e-4))
MASSES = {"plant.mass": np.linspace(4.0, 8.0, 3)}


LAWS = [PI, Backstepping, TSMC]


class Kept(PtxDevice):
    """A device that keeps the PTX it is given, and runs none."""

    def declare_device(self, *_: Any, link: bytes, **__: Any) -> Any:
        self.text = link.decode()


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], None]:
    """Lets kernels run on another device."""
    monkeypatch.setattr(native, "READY", {})
    return lambda device: monkeypatch.setattr(cuda, "cuda", device)


def ptx_of(law: Any, strict: bool) -> str:
    """The PTX of a loop's kernel."""
    loop, device = ready(LOOP._replace(controller=example(law))), Kept()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "READY", {})
        patch.setattr(cuda, "cuda", device)
        batch.kernel(loop, first_state(loop), 21, ("plant.mass",), strict, True)
    return device.text


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
    assert text.count(f".func  (.param .b64 func_retval0) {NAME}(") == 1
    assert not re.search(r"\.extern|\.global|\bcall", text.replace(".globl", ""))


def thread(compute: Callable[[float], float]) -> Callable[..., int]:
    """A function with the arguments of a kernel that computes something from dt."""

    def advance(constants, tables, memory, runs, thread, first, last, dt):  # type: ignore[no-untyped-def]
        return int(compute(dt))

    return advance


@pytest.mark.parametrize(
    ("compute", "name"),
    [
        (math.sin, "sin"),
        (math.exp, "exp"),
        (math.tanh, "tanh"),
        (lambda x: x**0.7, "pow"),
        (lambda x: x % 0.3, "fmod"),
    ],
)
def test_a_function_that_no_device_has_is_named(compute: Callable[[float], float], name: str) -> None:
    with pytest.raises(CompileError, match=rf"it calls .*{name}.*, which no CUDA device has"):
        ptx(thread(compute), cuda.ARGUMENTS, strict=True)


def test_an_exception_on_the_device_is_told() -> None:
    def compute(x: float) -> float:
        if x < 0.0:
            raise ValueError("negative")
        return 2.0 * x

    call = PtxFunction(ptx(thread(compute), cuda.ARGUMENTS, strict=True).code.decode())
    assert call(0, 0, 0, 1, 0, 0, 1, 21.0) == 42
    assert call(0, 0, 0, 1, 0, 0, 1, -1.0) == RAISED


def test_a_group_stops_where_a_block_raised(use: Callable[[Any], None]) -> None:
    class Raising(PtxDevice):
        def declare_device(self, *_: Any, **__: Any) -> Any:
            return lambda *_: RAISED

    use(Raising())
    with pytest.raises(LoopError, match="a block raised an exception"):
        simulate_batch(LOOP, MASSES, cuda=True)


def test_progress_rises_within_groups(use: Callable[[Any], None], monkeypatch: pytest.MonkeyPatch) -> None:
    use(PtxDevice())
    monkeypatch.setattr(cuda, "MOST", 2)
    monkeypatch.setattr(batch, "CUDA_CHUNK", 7)
    seen: list[float] = []
    simulate_batch(LOOP, MASSES, strict=True, cuda=True, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[0] == pytest.approx(7 / 21 * 2 / 3)
    assert seen[-1] == 1.0


@pytest.mark.parametrize(
    ("device", "said"),
    [
        (SimpleNamespace(), "cuda = True: numba-cuda is missing; pip install 'hydroservo[cuda]' brings it"),
        (
            SimpleNamespace(PTXSource=bytes, is_available=lambda: False),
            "cuda = True: there is no CUDA device, or no driver for it",
        ),
    ],
)
def test_what_is_missing_is_said_in_one_line(
    device: SimpleNamespace, said: str, use: Callable[[Any], None]
) -> None:
    use(device)
    with pytest.raises(ParameterError, match=rf"^{re.escape(said)}$"):
        simulate_batch(LOOP, MASSES, cuda=True)


@pytest.mark.parametrize("law", LAWS)
def test_numba_cuda_links_the_ptx_for_a_device(law: Any) -> None:
    """What numba-cuda does before it loads a kernel, here for an H200; it takes no device."""
    if not hasattr(numba_cuda, "PTXSource"):
        pytest.skip("numba-cuda is missing")
    nvjitlink = pytest.importorskip("cuda.bindings.nvjitlink")
    kernel = cuda.linked(MachineCode(NAME, ptx_of(law, strict=True).encode(), portable=True)).py_func
    whole, flags, number = types.int64, types.int64[::1], types.float64
    parts, _ = numba_cuda.compile_all(
        kernel,
        (whole, whole, whole, flags, whole, whole, number),
        device=False,
        abi="numba",
        output="ptx",
        cc=(9, 0),
    )
    linker = nvjitlink.create(1, ["-arch=sm_90"])
    for part in parts:
        code = part.encode() if isinstance(part, str) else part.data
        nvjitlink.add_data(linker, nvjitlink.InputType.PTX, code, len(code), "part")
    nvjitlink.complete(linker)
    assert len(parts) == 2
    assert nvjitlink.get_linked_cubin_size(linker) > 10_000
