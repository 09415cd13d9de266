"""PTX, the assembly language of CUDA devices, from the LLVM modules that machine code is made of.

llvmlite has LLVM's back end for it, so that no toolkit and no device is needed to make it. What a strict
kernel multiplies and adds is rounded each time: LLVM then writes ``mul.rn`` and ``add.rn``, which no later
compiler may fuse.
"""

import re
from collections.abc import Callable, Iterator

from llvmlite import binding
from numba import types
from numba.core.compiler_lock import global_compiler_lock

from hydroservo.engine.machine_code import DOUBLES, FLOAT, INTEGER, INTEGERS, PartLibrary, lowered
from hydroservo.engine.native import CompileError, MachineCode

__all__ = ["NAME", "RAISED", "ptx"]

NAME = "hydroservo_advance"  # of the function in the PTX
RAISED = -1  # what it returns if a block raised an exception
TRIPLE = "nvptx64-nvidia-cuda"
PROCESSOR = "sm_75"  # the oldest that CUDA 13 knows; the device's own compiler does the rest

LLVM_TYPES = {DOUBLES: "ptr", INTEGERS: "ptr", INTEGER: "i64", FLOAT: "double"}
# Those of LLVM's own functions that it leaves to a library; no device has one.
LIBRARY = re.compile(
    r"llvm\.(a?(sin|cos|tan)h?|atan2|sincos(pi)?|exp(2|10)?|frexp|ldexp|ll?(rint|round)|log(2|10)?|modf|powi?)\."
)


def ptx(function: Callable[..., int], arguments: tuple[types.Type, ...], strict: bool) -> MachineCode:
    """The PTX of a device function, called ``NAME``, that returns a whole number.

    Raises:
        CompileError: it cannot be compiled.
    """
    with global_compiler_lock:
        name, library = lowered(function, arguments, strict, PartLibrary)
        machine = device_machine()
        module = retargeted(str(library._final_module) + entry(name, arguments), machine)
    optimise(module, machine)
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


def entry(name: str, arguments: tuple[types.Type, ...]) -> str:
    """The text of the function that is called: the kernel without numba's places for result and exception."""
    given = ", ".join(f"{LLVM_TYPES[kind]} %a{i}" for i, kind in enumerate(arguments))
    return f"""
define i64 @{NAME}({given}) {{
  %result = alloca i64
  %exception = alloca ptr
  %status = call i32 @{name}(ptr %result, ptr %exception, {given})
  %fine = icmp eq i32 %status, 0
  %value = load i64, ptr %result
  %returned = select i1 %fine, i64 %value, i64 {RAISED}
  ret i64 %returned
}}
"""


def retargeted(text: str, machine: binding.TargetMachine) -> binding.ModuleRef:
    """The module of a text made for this processor, as one for the device; all but the entry is private."""
    text = re.sub(r"^target triple = .*$", f'target triple = "{TRIPLE}"', text, flags=re.MULTILINE)
    layout = f'target datalayout = "{machine.target_data}"'
    module = binding.parse_assembly(re.sub(r"^target datalayout = .*$", layout, text, flags=re.MULTILINE))
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and value.name != NAME:
            value.linkage = "internal"
    return module


def optimise(module: binding.ModuleRef, machine: binding.TargetMachine) -> None:
    options = binding.create_pipeline_tuning_options(speed_level=3)
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)


def foreign(module: binding.ModuleRef) -> Iterator[str]:
    """The functions that a module needs from a library."""
    for function in module.functions:
        if function.is_declaration and (
            LIBRARY.match(function.name) or not function.name.startswith("llvm.")
        ):
            yield function.name
    if " frem " in str(module):
        yield "fmod"
