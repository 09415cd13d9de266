"""Many runs side by side on a CUDA device: one thread a run.

A thread makes the blocks with its own parameters, loads its state from the device's memory, computes samples
with the text of single runs, and stores its state. That part is PTX of ours, linked into a small numba-cuda
kernel; numba-cuda does the rest. In its simulator the same text runs in plain Python instead.
"""

import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block
from hydroservo.engine import flat
from hydroservo.engine.kernel import Study, Wanted, kernel
from hydroservo.engine.lanes import Layout, layout_of, varier
from hydroservo.engine.machine_code import DOUBLES, FLOAT, INTEGER, INTEGERS
from hydroservo.engine.native import MachineCode, RunError, native
from hydroservo.engine.ptx import NAME, RAISED, ptx
from hydroservo.engine.recipe import Recipe
from hydroservo.engine.watch import Watch
from hydroservo.errors import ParameterError

try:
    from numba import config, cuda

    SIMULATED = bool(config.ENABLE_CUDASIM)
except ImportError:  # of the extra
    cuda, SIMULATED = None, False

__all__ = ["MOST", "CudaGroup", "CudaThreads"]

MOST = 2**17  # runs at once: several for each thread that the largest devices run, and little of their memory
BLOCK = 64  # threads that share a multiprocessor's registers; a thread of a large law needs all it may have
LOST, GOING = 0, 1  # a run whose state is no longer finite, and the others; or RAISED

ARGUMENTS = (DOUBLES, INTEGERS, DOUBLES, INTEGER, INTEGER, INTEGER, INTEGER, FLOAT)
SIGNATURE = "int64(int64, int64, int64, int64, int64, int64, int64, float64)"  # addresses as whole numbers


class CudaThreads:
    """The kernel of a study whose runs differ in some numbers of the system.

    Raises:
        ParameterError: numba-cuda or a device is missing.
        CompileError: the blocks cannot be compiled.
    """

    def __init__(self, study: Study, wanted: Wanted, state: Block, varied: tuple[str, ...], *, strict: bool):
        check_device()
        sums = study.watch.init()
        self.layout = layout_of(varied, state, sums)
        text = thread_text(study, wanted, state, sums, self.layout)
        if SIMULATED:
            self.launch = launcher(text)
        else:
            recipe = Recipe("threads", (*map(flat.shape, (study, state, sums)), *wanted, varied), strict)
            self.launch = native(recipe, lambda: ptx(text, ARGUMENTS, strict), linked)
        self.first_sums = flat.numbers(sums)
        self.constants, self.kept = cuda.to_device(flat.numbers(study)), device_arrays(study)
        self.tables = cuda.to_device(table(self.kept))


class CudaGroup:
    """Runs at their first sample, at most ``MOST``."""

    def __init__(self, threads: CudaThreads, parameters: Mapping[str, NDArray[np.float64]]) -> None:
        layout = threads.layout
        self.threads, self.runs = threads, next(iter(parameters.values())).size
        memory = np.zeros((layout.alive + 1, self.runs))  # the last row: samples done
        for row, path in enumerate(layout.varied):
            memory[row] = parameters[path]
        memory[layout.sums : layout.alive] = threads.first_sums[:, np.newaxis]
        self.memory = cuda.to_device(memory.reshape(-1))
        self.going = cuda.to_device(np.full(self.runs, GOING))

    def advance(self, first: int, last: int, dt: float) -> None:
        """Samples first to last-1 of every run that still goes on, to their end.

        Raises:
            RunError: a block raised an exception.
        """
        threads = self.threads
        places = (place(array) for array in (threads.constants, threads.tables, self.memory))
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Grid size")  # few runs leave a device idle; they are welcome
            threads.launch[-(-self.runs // BLOCK), BLOCK](*places, self.going, first, last, dt)
        cuda.synchronize()
        if (self.going.copy_to_host() == RAISED).any():
            raise RunError("a block raised an exception, which compiled code cannot carry")

    @property
    def sums(self) -> NDArray[np.float64]:
        """The monitors' state of each run, shape (numbers, runs)."""
        return self.rows(self.threads.layout.sums, self.threads.layout.alive)

    @property
    def states(self) -> NDArray[np.float64]:
        """The state of each run, shape (numbers, runs)."""
        return self.rows(self.threads.layout.states, self.threads.layout.sums)

    @property
    def done(self) -> NDArray[np.int64]:
        """How many samples each run has done, the one that lost it not among them."""
        alive = self.threads.layout.alive
        found: NDArray[np.int64] = self.rows(alive, alive + 1)[0].astype(np.int64)
        return found

    def rows(self, first: int, last: int) -> NDArray[np.float64]:
        """Rows first to last-1 of the memory."""
        part = self.memory[first * self.runs : last * self.runs]
        found: NDArray[np.float64] = part.copy_to_host().reshape(-1, self.runs)
        return found

    @property
    def lost(self) -> NDArray[np.bool_]:
        """True for each run whose state is no longer finite."""
        found: NDArray[np.bool_] = self.going.copy_to_host() == LOST
        return found


def thread_text(
    study: Study, wanted: Wanted, state: Block, sums: Watch, layout: Layout
) -> Callable[..., int]:
    """The function that a thread calls."""
    build, own_of = flat.builder(study), varier(study.system, layout.varied, row(0))
    state_of, sums_of = flat.loader(state, row(layout.states)), flat.loader(sums, row(layout.sums))
    put_state, put_sums = flat.storer(state, row(layout.states)), flat.storer(sums, row(layout.sums))
    run = kernel(study, wanted)
    samples_done = layout.alive

    def advance(constants, tables, memory, runs, thread, first, last, dt):  # type: ignore[no-untyped-def]
        """Samples first to last-1 of one run; returns whether its state is still finite, GOING or LOST."""
        system, integrator, periods, substeps, watch = build(constants, tables)
        lane = (runs, thread)
        own = own_of(system, memory, lane)
        if first == 0:
            put_state(memory, lane, own.init())
        s, m = state_of(memory, lane), sums_of(memory, lane)
        s, m, done = run(own, integrator, periods, substeps, watch, s, m, first, last, dt, 1, memory)
        put_state(memory, lane, s)
        put_sums(memory, lane, m)
        memory[samples_done * runs + thread] = float(done)
        return int(done == last)

    return advance


def row(first: int) -> flat.Place:
    """The index of a run's number in the i-th row from one on: neighbouring threads read side by side."""
    return lambda i: f"{first + i} * lane[0] + lane[1]"


def launcher(advance: Callable[..., int]) -> Any:
    """The kernel: each thread advances its run."""

    @cuda.jit
    def launch(constants, tables, memory, going, first, last, dt):  # type: ignore[no-untyped-def]
        thread = cuda.grid(1)
        if thread < going.size and going[thread] == GOING:
            going[thread] = advance(constants, tables, memory, going.size, thread, first, last, dt)

    return launch


def linked(made: MachineCode) -> Any:
    """The kernel that calls a function in PTX."""
    return launcher(cuda.declare_device(NAME, SIGNATURE, link=cuda.PTXSource(made.code), abi="c"))


def check_device() -> None:
    """Raises ParameterError unless there is something to run on."""
    if not SIMULATED and not hasattr(cuda, "PTXSource"):
        raise ParameterError("cuda", True, "numba-cuda is missing; pip install 'hydroservo[cuda]' brings it")
    if not cuda.is_available():
        raise ParameterError("cuda", True, "there is no CUDA device, or no driver for it")


def device_arrays(study: Study) -> list[Any]:
    """The arrays of a study, copied to the device."""
    return [cuda.to_device(value) for value in flat.doubles(study)]


def table(arrays: list[Any]) -> NDArray[np.int64]:
    """Address and lengths of each array on the device, as ``flat.arrays`` has them of those in memory."""
    found = [number for array in arrays for number in (address(array), *array.shape)]
    return np.array(found or [0], dtype=np.int64)  # no device keeps arrays of no numbers


def address(array: Any) -> int:
    where = array.ctypes.data if SIMULATED else array.__cuda_array_interface__["data"][0]
    return int(where)


def place(array: Any) -> Any:
    """An array as the kernel takes it: in PTX its address, in Python itself."""
    return array if SIMULATED else address(array)
