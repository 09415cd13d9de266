"""PTX, the assembly language of CUDA devices, from the text that machine code is made of.

llvmlite has LLVM's back end for it, so that no toolkit and no device is needed to make it. What a strict
kernel multiplies and adds is rounded each time: LLVM then writes ``mul.rn`` and ``add.rn``, which no later
compiler may fuse.
"""

import re
from collections.abc import Callable, Iterator

from llvmlite import binding

from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS, kernel_text
from hydroservo.engine.machine_code import optimise, with_interleaving
from hydroservo.engine.native import CompileError, MachineCode
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
    """The functions that a module needs from a library."""
    for function in module.functions:
        if function.is_declaration and (
            LIBRARY.match(function.name) or not function.name.startswith("llvm.")
        ):
            yield function.name
    if " frem " in str(module):
        yield "fmod"
