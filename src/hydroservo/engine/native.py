"""Machine code as something to call: from memory, from the disk cache, or made now."""

import ctypes
import logging
from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from llvmlite import binding

from hydroservo.engine import disk_cache
from hydroservo.engine.recipe import KernelKey, UnknownContentError


class CompileError(Exception):
    """The blocks cannot be compiled.

    Attributes:
        places: the files and lines that it is about, from the inside out, where it is about any.
    """

    def __init__(self, message: str, places: Sequence[tuple[str, int]] = ()) -> None:
        super().__init__(message)
        self.places = places


class RunError(Exception):
    """A block raised an exception while it ran; it is the cause, where plain Python has one."""


class MachineCode(NamedTuple):
    """An object file with one function to call."""

    name: str
    code: bytes
    portable: bool  # needs nothing from the process that made it


ELEMENTS = (np.dtype(np.float64), np.dtype(np.int64))
LIMIT = 2**63  # ctypes drops the bits above


class Linked:
    """Machine code in memory; its function returns 0, or 1 where a block raised."""

    def __init__(self, made: MachineCode) -> None:
        prepare_llvm()
        machine = binding.Target.from_default_triple().create_target_machine()
        self.engine = binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
        self.engine.add_object_file(binding.ObjectFileRef.from_data(made.code))
        self.engine.finalize_object()
        self.function = ctypes.CFUNCTYPE(ctypes.c_int32)(self.engine.get_function_address(made.name))


class Native(Linked):
    """A compiled function of arrays and numbers that returns a whole number.

    It takes where to put that and then the arguments.
    """

    def __call__(self, *arguments: Any) -> int:
        result = ctypes.c_int64()
        if self.function(ctypes.byref(result), *(c_argument(value) for value in arguments)) != 0:
            raise RunError("a block raised an exception, which compiled code cannot carry")
        return result.value


def c_argument(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        if value.dtype not in ELEMENTS or not value.flags.carray:
            raise TypeError(
                f"a kernel takes contiguous, writeable arrays of 64-bit numbers, not {value.dtype}"
            )
        return ctypes.c_void_p(value.ctypes.data)
    if isinstance(value, float):
        return ctypes.c_double(value)
    if not -LIMIT <= value < LIMIT:
        raise OverflowError(f"{value} does not fit into 64 bits")
    return ctypes.c_int64(value)


@cache
def prepare_llvm() -> None:
    """LLVM's back end for this processor."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


READY: dict[Any, Any] = {}
LOG = logging.getLogger(__name__)
LOCK = Lock()  # two threads that ask for one kernel get one, compiled once


def native_kernel(
    recipe: KernelKey, make: Callable[[], MachineCode], link: Callable[[MachineCode], Any] = Native
) -> Any:
    """The kernel of a recipe: the one of before, the one on disk, or a new one, made callable by ``link``."""
    key = recipe, recipe.methods()
    with LOCK:
        if key in READY:
            LOG.debug("kernel '%s' from memory", recipe.text)
        else:
            READY[key] = link(kernel_on_disk(recipe, make))
        return READY[key]


def kernel_on_disk(recipe: KernelKey, make: Callable[[], MachineCode]) -> MachineCode:
    """The kernel on disk, or a new one, kept there if it can be; the log says which, and why."""
    start = monotonic()
    digest, kept, remarks = None, None, []
    try:
        digest = recipe.digest()
        kept = disk_cache.read_kernel(digest)
    except UnknownContentError as error:
        remarks.append(f"it cannot be kept: {error}")
    except OSError as error:
        remarks.append(cache_problem(error))
    if kept is not None:
        LOG.info("kernel '%s' read from disk in %.2f s", recipe.text, monotonic() - start)
        return MachineCode(*kept, portable=True)
    made = make()
    seconds = monotonic() - start
    if digest is not None:
        remarks.append(keep_kernel(digest, made))
    LOG.info("kernel '%s' compiled in %.1f s; %s", recipe.text, seconds, "; ".join(dict.fromkeys(remarks)))
    return made


def cache_problem(error: OSError) -> str:
    """What is wrong with the cache; the same whether it was read or written."""
    if isinstance(error, disk_cache.CacheError):
        return f"cache: {error}"
    return f"cache: {disk_cache.directory()}: {error.strerror}"


def keep_kernel(digest: str, made: MachineCode) -> str:
    """Keeps a kernel on disk if it can be, and says whether."""
    if not made.portable:
        return "it cannot be kept: it calls functions of this process"
    try:
        disk_cache.write_kernel(digest, made.name, made.code)
    except OSError as error:
        return cache_problem(error)
    return "kept on disk"
