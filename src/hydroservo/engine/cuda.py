"""Many runs side by side on a CUDA device: one thread a run.

A thread makes the blocks with its own parameters, loads its state from the device's memory, computes samples
with the text of single runs, and stores its state.
"""

import re
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from llvmlite import binding
from numpy.typing import NDArray

from hydroservo.core.block import Block
from hydroservo.engine import flat
from hydroservo.engine.cuda_driver import DeviceKernel, DeviceMemory, device
from hydroservo.engine.kernel import Recording, RunSpec, has_single_steps, sample_kernel
from hydroservo.engine.lanes import LaneLayout, lane_layout, varier
from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS, kernel_text
from hydroservo.engine.machine_code import optimise, with_interleaving
from hydroservo.engine.native import CompileError, MachineCode, RunError, native_kernel
from hydroservo.engine.recipe import KernelKey
from hydroservo.engine.watch import MonitorGroups
from hydroservo.language.terms import INT, REAL

NAME = "hydroservo_threads"  # of the kernel
INNER = "hydroservo_kernel"  # of what a thread does, which is inlined
RAISED = -1  # a run in which a block raised an exception
LOST = 0  # one that lost a number
GOING = 1  # one that goes on
THREADS = 64  # of a block
FEW, ALL = 128, 255  # registers of a thread: the fewer, the more threads hide each other's waits
MOST = 500  # numbers that are given by value; devices take four kilobytes so
TRIPLE = "nvptx64-nvidia-cuda"
PROCESSOR = "sm_75"  # the oldest that CUDA 13 knows; the device's own compiler does the rest

# Those of LLVM's own functions that it leaves to a library; no device has one.
LIBRARY = re.compile(
    r"llvm\.(a?(sin|cos|tan)h?|atan2|sincos(pi)?|exp(2|10)?|frexp|ldexp|ll?(rint|round)|log(2|10)?|modf|powi?)\."
)
# Constants, the table of arrays, the memory of all runs, how many there are, which of them, samples, dt.
ARGUMENTS = (DOUBLES, INTEGERS, DOUBLES, INT, INT, INT, INT, REAL)


def ptx(function: Callable[..., int], constants: int, strict: bool) -> MachineCode:
    """The PTX of a kernel whose threads each do what a function does with one run.

    Args:
        function: ``function(constants, tables, memory, runs, thread, first, last, dt)``, which returns LOST
            or GOING.
        constants: how many numbers all runs share.
        strict: True rounds after every operation.
    """
    if constants > MOST:
        raise CompileError(f"a CUDA device takes {MOST} numbers of blocks, and these have {constants}")
    inner = kernel_text(INNER, function, ARGUMENTS).replace("define i32", "define internal i32")
    machine = device_machine()
    module = optimise(with_interleaving(inner + kernel_entry(constants), 1), TRIPLE, machine, strict)
    missing = sorted(library_functions(module))
    if missing:
        raise CompileError(f"it calls {', '.join(missing)}, which no CUDA device has")
    return MachineCode(NAME, machine.emit_assembly(module).encode(), portable=True)


def with_all_registers(code: bytes) -> bytes:
    """The PTX of a kernel whose threads take all the registers that they may."""
    return code.replace(f".maxnreg {FEW}".encode(), f".maxnreg {ALL}".encode())


def device_machine() -> binding.TargetMachine:
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine: binding.TargetMachine = binding.Target.from_triple(TRIPLE).create_target_machine(
        cpu=PROCESSOR, opt=3
    )
    return machine


def kernel_entry(constants: int) -> str:
    """The text of the kernel: each thread advances its run, if it still goes on, and keeps what became of it.

    Constants are given by value, which keeps them where operations read them without a register.
    """
    return f"""
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()

define ptx_kernel void @{NAME}(ptr byval([{constants} x double]) align 8 %constants,
    ptr noalias readonly %tables, ptr noalias %memory, ptr noalias %going, i64 %runs,
    i64 %first, i64 %last, double %dt)
    "nvvm.maxntid"="{THREADS}" "nvvm.maxnreg"="{FEW}" {{
  %result = alloca i64, align 8
  %place = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %start = mul i32 %block, {THREADS}
  %number = add i32 %start, %place
  %thread = zext i32 %number to i64
  %there = icmp slt i64 %thread, %runs
  br i1 %there, label %look, label %end
look:
  %state = getelementptr i64, ptr %going, i64 %thread
  %before = load i64, ptr %state, align 8
  %goes = icmp eq i64 %before, {GOING}
  br i1 %goes, label %advance, label %end
advance:
  %status = call i32 @{INNER}(ptr %result, ptr %constants, ptr %tables, ptr %memory, i64 %runs, i64 %thread,
    i64 %first, i64 %last, double %dt) alwaysinline
  %fine = icmp eq i32 %status, 0
  %value = load i64, ptr %result, align 8
  %after = select i1 %fine, i64 %value, i64 {RAISED}
  store i64 %after, ptr %state, align 8
  br label %end
end:
  ret void
}}
"""


def library_functions(module: binding.ModuleRef) -> Iterator[str]:
    for function in module.functions:
        if function.is_declaration and (
            LIBRARY.match(function.name) or not function.name.startswith("llvm.")
        ):
            yield function.name
    if " frem " in str(module):
        yield "fmod"


SPILLED = 1200  # bytes of memory that a thread may need with few registers
WAVES = 4  # runs at once, in so many as the device computes at a time


class CudaThreads:
    """The kernel of a study whose runs differ in some numbers of the system.

    Raises:
        ParameterError: cuda-bindings or a device is missing.
        CompileError: the blocks cannot be compiled.
    """

    def __init__(
        self, study: RunSpec, wanted: Recording, state: Block, varied: tuple[str, ...], *, strict: bool
    ):
        device().use()
        sums = study.watch.init()
        self.layout = lane_layout(varied, state, sums)
        self.constants = flat.block_numbers(study)
        shapes = (*map(flat.block_shape, (study, state, sums)), *wanted, varied, has_single_steps(study))
        recipe = KernelKey("threads", shapes, strict)
        text = thread_text(study, wanted, state, sums, self.layout)
        self.kernel = native_kernel(recipe, lambda: ptx(text, self.constants.size, strict), load_kernel)
        self.most = WAVES * self.kernel.resident(THREADS)
        self.first_sums = flat.block_numbers(sums)
        self.kept = [DeviceMemory(array) for array in flat.double_arrays(study)]
        self.tables = DeviceMemory(array_table(study, self.kept))


class CudaGroup:
    """Runs at their first sample."""

    def __init__(self, threads: CudaThreads, parameters: Mapping[str, NDArray[np.float64]]) -> None:
        layout = threads.layout
        self.threads, self.runs = threads, next(iter(parameters.values())).size
        memory = np.zeros((layout.alive + 1, self.runs))  # the last row: samples done
        for row, path in enumerate(layout.varied):
            memory[row] = parameters[path]
        memory[layout.sums : layout.alive] = threads.first_sums[:, np.newaxis]
        self.memory = DeviceMemory(memory)
        self.going = DeviceMemory(np.full(self.runs, GOING, dtype=np.int64))

    def advance(self, first: int, last: int, dt: float) -> None:
        """Samples first to last-1 of every run that still goes on, to their end."""
        threads = self.threads
        places = (threads.tables.address, self.memory.address, self.going.address)
        whole = np.array([*places, self.runs, first, last], dtype=np.int64)
        arguments = [threads.constants, *(whole[i : i + 1] for i in range(whole.size)), np.array([dt])]
        threads.kernel.launch(-(-self.runs // THREADS), THREADS, arguments)

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
        return self.memory.read(first * self.runs, last * self.runs).reshape(-1, self.runs)

    @property
    def lost(self) -> NDArray[np.bool_]:
        """True for each run whose state is no longer finite."""
        states = self.going.read()
        if (states == RAISED).any():
            raise RunError("a block raised an exception, which compiled code cannot carry")
        found: NDArray[np.bool_] = states == LOST
        return found


def thread_text(
    study: RunSpec, wanted: Recording, state: Block, sums: MonitorGroups, layout: LaneLayout
) -> Callable[..., int]:
    """The function that a thread calls."""
    build, own_of = flat.builder(study), varier(study.system, layout.varied, thread_index(0))
    at_states, at_sums = thread_index(layout.states), thread_index(layout.sums)
    state_of, sums_of = flat.loader(state, at_states), flat.loader(sums, at_sums)
    put_state, put_sums = flat.storer(state, at_states), flat.storer(sums, at_sums)
    run = sample_kernel(study, wanted)
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


def thread_index(first: int) -> flat.Place:
    """The index of a run's number in the i-th row from one on: neighbouring threads read side by side."""
    return lambda i: f"{first + i} * lane[0] + lane[1]"


def load_kernel(made: MachineCode) -> DeviceKernel:
    """The kernel on the device, with few registers for a thread where these nearly do.

    What does not fit into registers stands in memory, which costs little up to some size: of five laws on an
    H200 the three below it are 10 to 15 % faster so, and the two above it 1.6 and 1.9 times slower.
    """
    kernel = DeviceKernel(made.code, made.name)
    if kernel.spilled_bytes() > SPILLED:
        kernel = DeviceKernel(with_all_registers(made.code), made.name)
    return kernel


def array_table(study: RunSpec, arrays: list[DeviceMemory]) -> NDArray[np.int64]:
    """Address and lengths of each array on the device, as ``flat.arrays`` has them of those in memory."""
    pairs = zip(arrays, flat.double_arrays(study), strict=True)
    found = [number for there, here in pairs for number in (there.address, *here.shape)]
    return np.array(found or [0], dtype=np.int64)  # no device keeps arrays of no numbers
