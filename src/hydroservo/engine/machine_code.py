"""Compiles kernels to machine code: numba to LLVM, LLVM to an object file.

Everything a kernel calls is inlined into one function that takes numbers and pointers only, allocates
nothing and touches no Python object, so that its object file can be kept and loaded without numba.
"""

import gc
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from llvmlite import binding
from numba import config, njit, types
from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from hydroservo.engine import arithmetic  # noqa: F401 - teaches numba the arithmetic on states
from hydroservo.engine.jit import CONTRACT, INLINE, WAY_OUT, places, said
from hydroservo.engine.native import CompileError, MachineCode

__all__ = ["DOUBLES", "FLOAT", "INTEGER", "INTEGERS", "PartLibrary", "inlined", "lowered", "machine_code"]

FLOAT = types.float64
INTEGER = types.int64
DOUBLES = types.CPointer(FLOAT)
INTEGERS = types.CPointer(INTEGER)

OPTIONS = {
    "nopython": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "error_model": "numpy",
    "_nrt": False,
}
PROVIDED = {"memcpy", "memset", "memmove"}  # what LLVM itself may call, in every C library

WIDE = 4  # vectors that go together, with the 32 registers of AVX-512
NARROW = 2  # with fewer registers
DEFINITION = re.compile(r"^(define .*) {$", re.MULTILINE)
LABEL = re.compile(r"^([\w.$\"-]+):")
TARGET = re.compile(r"label %([\w.$\"-]+)")


class PartLibrary(JITCodeLibrary):
    """The LLVM module of a function to be inlined: left as it is, for the kernel is optimised whole."""

    _final_module: Any

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True


Library = TypeVar("Library", bound=PartLibrary)


class KernelLibrary(PartLibrary):
    """The LLVM module of a kernel."""

    def _optimize_final_module(self) -> None:
        text, wide = str(self._final_module), "+avx512f" in self._codegen._tm_features
        text = interleaved(widest(text), WIDE) if wide else interleaved(text, NARROW)
        self._final_module = binding.parse_assembly(text)
        JITCodeLibrary._optimize_final_module(self)

    def object_code(self) -> bytes:
        code: bytes = self._codegen._tm.emit_object(self._final_module)
        return code

    def foreign(self) -> Iterator[str]:
        """The functions that the module calls and does not hold."""
        for function in self._final_module.functions:
            if function.is_declaration and not function.name.startswith("llvm."):
                yield function.name


def widest(module: str) -> str:
    """The text of a module whose functions take the widest vectors that AVX-512 has.

    For many processors LLVM prefers half the width, since programs that seldom need vectors lose more by a
    lower clock than they gain; here nearly all the work is in loops over lanes.
    """
    return DEFINITION.sub(r'\1 "prefer-vector-width"="512" {', module)


def interleaved(module: str, vectors: int) -> str:
    """The text of a module that asks for so many vectors at a time in each loop that is vectorised.

    While one waits for its operations to end, the others go on.
    """
    lines: list[str] = []
    loops: list[str] = []
    seen: set[str] = set()
    first = 1 + max((int(number) for number in re.findall(r"^!(\d+) =", module, re.MULTILINE)), default=0)
    for line in module.splitlines():
        label = LABEL.match(line)
        seen = set() if line.startswith("define") else seen | ({label[1]} if label else set())
        backward = line.startswith("  br ") and seen.intersection(TARGET.findall(line))
        node = first + 1 + len(loops)
        lines.append(f"{line}, !llvm.loop !{node}" if backward else line)
        loops += [f"!{node} = distinct !{{!{node}, !{first}}}"] if backward else []
    wish = f'!{first} = !{{!"llvm.loop.interleave.count", i32 {vectors}}}'
    return "\n".join([*lines, wish, *loops, ""])


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function that kernels call without a call."""
    dispatcher: Callable[..., Any] = njit(**INLINE)(function)
    return dispatcher


def machine_code(
    function: Callable[..., Any], arguments: tuple[types.Type, ...], strict: bool
) -> MachineCode:
    """The object code of a kernel that returns a whole number.

    Raises:
        CompileError: it cannot be compiled.
    """
    with global_compiler_lock, uncollected():
        name, library = lowered(function, arguments, strict, KernelLibrary)
        foreign = set(library.foreign()) - PROVIDED
        missing = sorted(name for name in foreign if binding.address_of_symbol(name) is None)
        if missing:
            raise CompileError(f"it calls {', '.join(missing)}")
        return MachineCode(name, library.object_code(), portable=not foreign)


def lowered(
    function: Callable[..., Any], arguments: tuple[types.Type, ...], strict: bool, kind: type[Library]
) -> tuple[str, Library]:
    """The name of a kernel in an LLVM module of this kind.

    Raises:
        CompileError: it cannot be compiled.
    """
    if config.DISABLE_JIT:
        raise CompileError("NUMBA_DISABLE_JIT is set; compiled=False runs a loop in plain Python")
    flags = compiler.Flags()
    cpu_target.options.parse_as_flags(flags, OPTIONS if strict else OPTIONS | {"fastmath": CONTRACT})
    flags.no_compile = True
    typing, target = cpu_target.typing_context, cpu_target.target_context
    typing.refresh()
    target.refresh()
    library = kind(target.codegen(), function.__name__)
    try:
        with parts_only(target.codegen()):
            result = compiler.compile_extra(
                typing, target, function, arguments, types.int64, flags, {}, library
            )
        library.finalize()
    except Exception as error:  # whatever numba stumbles over, it is about this text
        raise CompileError(f"{said(error)}; {WAY_OUT}", places(error)) from None
    return result.fndesc.llvm_func_name, library


@contextmanager
def uncollected() -> Iterator[None]:
    """No garbage collection: a compiler keeps nearly all that it makes, and searching that takes time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@contextmanager
def parts_only(codegen: Any) -> Iterator[None]:
    """Lets numba make parts to be inlined, not functions, which it would optimise one by one."""
    codegen._library_class = PartLibrary
    codegen.set_env = lambda *_: None  # of Python functions, where exceptions look for their text
    try:
        yield
    finally:
        del codegen._library_class, codegen.set_env
