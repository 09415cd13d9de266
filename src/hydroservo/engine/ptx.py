"""PTX, the assembly language of CUDA devices, from the text that machine code is made of.

llvmlite has LLVM's back end for it, so that no toolkit and no device is needed to make it. What a strict
kernel multiplies and adds is rounded each time: LLVM then writes ``mul.rn`` and ``add.rn``, which no later
compiler may fuse.
"""

import re
from collections.abc import Callable, Iterator, Sequence

from llvmlite import binding

from hydroservo.engine.lower.function import kernel_text, types_of
from hydroservo.engine.machine_code import interleaved, optimised
from hydroservo.engine.native import CompileError, MachineCode

__all__ = ["NAME", "RAISED", "ptx"]

NAME = "hydroservo_advance"  # of the function in the PTX
INNER = "hydroservo_kernel"  # of the one that it calls, which is inlined
RAISED = -1  # what it returns if a block raised an exception
TRIPLE = "nvptx64-nvidia-cuda"
PROCESSOR = "sm_75"  # the oldest that CUDA 13 knows; the device's own compiler does the rest

# Those of LLVM's own functions that it leaves to a library; no device has one.
LIBRARY = re.compile(
    r"llvm\.(a?(sin|cos|tan)h?|atan2|sincos(pi)?|exp(2|10)?|frexp|ldexp|ll?(rint|round)|log(2|10)?|modf|powi?)\."
)


def ptx(function: Callable[..., int], arguments: Sequence[str], strict: bool) -> MachineCode:
    """The PTX of a device function, called ``NAME``, that returns a whole number.

    Raises:
        CompileError: it cannot be compiled.
    """
    inner = kernel_text(INNER, function, arguments).replace("define ", "define internal ")
    text = inner + entry(arguments)
    machine = device_machine()
    module = optimised(interleaved(text, 1), TRIPLE, machine, strict)
    missing = sorted(foreign(module))
    if missing:
        raise CompileError(f"it calls {', '.join(missing)}, which no CUDA device has")
    return MachineCode(NAME, machine.emit_assembly(module).encode(), portable=True)


def device_machine() -> binding.TargetMachine:
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine: binding.TargetMachine = binding.Target.from_triple(TRIPLE).create_target_machine(
        cpu=PROCESSOR, opt=3
    )
    return machine


def entry(arguments: Sequence[str]) -> str:
    """The text of the function that is called: the kernel without a place for its result."""
    given = ", ".join(f"{kind} %a{i}" for i, kind in enumerate(types_of(arguments)))
    return f"""
define i64 @{NAME}({given}) {{
  %result = alloca i64, align 8
  %status = call i32 @{INNER}(ptr %result, {given})
  %fine = icmp eq i32 %status, 0
  %value = load i64, ptr %result, align 8
  %returned = select i1 %fine, i64 %value, i64 {RAISED}
  ret i64 %returned
}}
"""


def foreign(module: binding.ModuleRef) -> Iterator[str]:
    """The functions that a module needs from a library."""
    for function in module.functions:
        if function.is_declaration and (
            LIBRARY.match(function.name) or not function.name.startswith("llvm.")
        ):
            yield function.name
    if " frem " in str(module):
        yield "fmod"
