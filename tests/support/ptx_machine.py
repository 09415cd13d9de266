"""A machine for PTX in plain Python: what a CUDA device does with each thread, instruction by instruction.

It knows the instructions that kernels consist of, by their definition in the PTX ISA; numbers are rounded as
IEEE 754 asks. Registers hold 64 bits; addresses are those of this process.
"""

import ctypes
import itertools
import math
import operator
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

from hydroservo.engine import cuda_driver, native

WORD = 2**64 - 1
SIGN = 2**63
NAN = 0x7FFFFFFFFFFFFFFF


def double(bits: int) -> float:
    value: float = struct.unpack("<d", struct.pack("<Q", bits))[0]
    return value


def bits(value: float) -> int:
    return NAN if value != value else int(struct.unpack("<Q", struct.pack("<d", value))[0])  # noqa: PLR0124


def signed(word: int) -> int:
    return word - 2**64 if word & SIGN else word


def quotient(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    return math.nan if a == 0.0 or a != a else math.copysign(math.inf, a) * math.copysign(1.0, b)  # noqa: PLR0124


def root(a: float) -> float:
    return math.sqrt(a) if a >= 0.0 else math.nan


def extreme(choose: Callable[[float, float], float]) -> Callable[[float, float], float]:
    """max or min: a number rather than a nan, and +0 above -0."""

    def chosen(a: float, b: float) -> float:
        if a != a or b != b:  # noqa: PLR0124
            return b if a != a else a  # noqa: PLR0124
        if a == b:
            return choose(a, b, key=lambda x: math.copysign(1.0, x))  # type: ignore[call-arg]
        return choose(a, b)

    return chosen


def toward_zero(a: float) -> int:
    if a != a:  # noqa: PLR0124
        return 0
    return max(-SIGN, min(SIGN - 1, int(a))) if math.isfinite(a) else (SIGN - 1 if a > 0.0 else -SIGN)


def down(a: float) -> float:
    return math.copysign(float(math.floor(a)), a) if math.isfinite(a) else a


DOUBLES: dict[str, Callable[..., float]] = {
    "add.rn": operator.add,
    "sub.rn": operator.sub,
    "mul.rn": operator.mul,
    "div.rn": quotient,
    "rcp.rn": lambda a: quotient(1.0, a),
    "sqrt.rn": root,
    "max": extreme(max),
    "min": extreme(min),
    "cvt.rmi.f64": down,
}
WORDS: dict[str, Callable[..., int]] = {
    "mov.b64": lambda a: a,
    "mov.u32": lambda a: a,
    "shl.b32": lambda a, b: a << b & 0xFFFFFFFF,
    "or.b32": operator.or_,
    "cvt.u64.u32": lambda a: a,
    "cvta.to.global.u64": lambda a: a,  # all addresses are alike here
    "abs.f64": lambda a: a & ~SIGN,
    "neg.f64": lambda a: a ^ SIGN,
    "copysign.f64": lambda a, b: (a & SIGN) | (b & ~SIGN),
    "and.b64": operator.and_,
    "or.b64": operator.or_,
    "xor.b64": operator.xor,
    "not.b64": operator.invert,
    "neg.s64": operator.neg,
    "add.s64": operator.add,
    "add.u64": operator.add,
    "sub.s64": operator.sub,
    "mul.lo.s64": operator.mul,
    "mad.lo.s64": lambda a, b, c: a * b + c,
    "shl.b64": lambda a, b: a << b if b < 64 else 0,
    "shr.u64": lambda a, b: a >> b,
    "shr.s64": lambda a, b: signed(a) >> b,
    "bfe.u64": lambda a, first, count: a >> first & (1 << count) - 1,
    "max.s64": lambda a, b: max(signed(a), signed(b)),
    "min.s64": lambda a, b: min(signed(a), signed(b)),
    "cvt.u32.u64": lambda a: a & 0xFFFFFFFF,
    "cvt.rn.f64.s64": lambda a: bits(float(signed(a))),
    "cvt.rn.f64.u64": lambda a: bits(float(a)),
    "cvt.rzi.s64.f64": lambda a: toward_zero(double(a)),
}
COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    name: getattr(operator, name) for name in ("eq", "ne", "lt", "le", "gt", "ge")
}
LOGIC: dict[str, Callable[..., bool]] = {
    "and.pred": operator.and_,
    "or.pred": operator.or_,
    "xor.pred": operator.xor,
    "not.pred": operator.not_,
    "mov.pred": lambda a: a,
}


def compared(name: str, kind: str) -> Callable[[int, int], bool]:
    """The comparison of setp; those ending in u hold for nan too."""
    if kind != "f64":
        convert = signed if kind == "s64" else int
        return lambda a, b: COMPARED[name](convert(a), convert(b))

    def holds(a: int, b: int) -> bool:
        x, y = double(a), double(b)
        unordered = x != x or y != y  # noqa: PLR0124
        if unordered or name in ("num", "nan"):
            return unordered if name == "nan" else unordered and name.endswith("u")
        return COMPARED[name.removesuffix("u") if len(name) == 3 else name](x, y)

    return lambda a, b: not compared("nan", kind)(a, b) if name == "num" else holds(a, b)


def meaning(name: str) -> Callable[..., Any]:
    """What an instruction makes of the words it reads.

    Raises:
        KeyError: it is not known here.
    """
    if name.startswith("setp."):
        return compared(*name.split(".")[1:])
    if name.startswith("selp."):
        return lambda a, b, chosen: a if chosen else b
    if name in LOGIC:
        return LOGIC[name]
    if name in WORDS:
        return lambda *given: WORDS[name](*given) & WORD
    compute = DOUBLES[name.removesuffix(".f64")]
    return lambda *given: bits(compute(*map(double, given)))


class Step(NamedTuple):
    """One instruction."""

    name: str
    guard: str  # a predicate, with ! before it if it must not hold
    operands: tuple[str, ...]
    act: Callable[..., Any] | None


class PtxKernel:
    """A kernel of a PTX text, run for one thread after the other."""

    def __init__(self, text: str, name: str) -> None:
        assert f".visible .entry {name}(" in text
        self.name, self.body = name, text[text.index("{") + 1 : text.rindex("}")]
        self.places: dict[str, int] = {}

    @cached_property
    def steps(self) -> list[Step]:
        """The instructions; known only once they are to run."""
        found: list[Step] = []
        for line in instructions(self.body):
            if line.endswith(":"):
                self.places[line[:-1]] = len(found)
            else:
                found.append(step(line))
        return found

    def launch(self, blocks: int, threads: int, arguments: Sequence[int]) -> None:
        """Runs all threads, with the addresses of the kernel's arguments."""
        places = {f"{self.name}_param_{i}": address for i, address in enumerate(arguments)}
        for block, thread in itertools.product(range(blocks), range(threads)):
            self.run({"%ctaid.x": block, "%tid.x": thread} | places)

    def run(self, memory: dict[str, Any]) -> None:
        at = 0
        while True:
            name, guard, operands, act = self.steps[at]
            at += 1
            if guard and memory[guard.lstrip("!")] == guard.startswith("!"):
                continue
            if act is not None:
                memory[operands[0]] = act(*(value(memory, operand) for operand in operands[1:]))
            elif name == "bra":
                at = self.places[operands[0]]
            elif name.startswith("ld."):
                memory[operands[0]] = cell(memory, operands[1]).value
            elif name.startswith("st."):
                cell(memory, operands[0]).value = value(memory, operands[1])
            else:
                assert name == "ret", name
                return


def instructions(body: str) -> Iterator[str]:
    """Labels and instructions, one a line."""
    for raw in body.splitlines():
        line = raw.partition("//")[0].strip()
        if line and not line.startswith("."):
            yield line


def step(line: str) -> Step:
    found = re.fullmatch(r"(?:@(!?%p\d+)\s+)?(\S+?)(?:\s+(.*))?;", line)
    assert found, line
    guard, name, rest = found[1] or "", found[2], found[3] or ""
    operands = tuple(part.strip() for part in rest.split(",")) if rest else ()
    own = name in ("bra", "bra.uni", "ret") or name.startswith(("ld.", "st."))
    return Step(name.removesuffix(".uni"), guard, operands, None if own else meaning(name))


def value(memory: dict[str, Any], operand: str) -> Any:
    if operand in memory:
        return memory[operand]
    return int(operand[2:], 16) if operand.startswith("0d") else int(operand, 0) & WORD


def cell(memory: dict[str, Any], operand: str) -> ctypes.c_uint64:
    """The eight bytes at an address such as [%rd1+8]."""
    base, _, offset = operand.strip("[]").partition("+")
    return ctypes.c_uint64.from_address((memory[base] + int(offset or 0)) & WORD)


class Status(IntEnum):
    """What calls of a driver return."""

    CUDA_SUCCESS = 0
    CUDA_ERROR_OUT_OF_MEMORY = 2
    CUDA_ERROR_NO_DEVICE = 100


class PtxDriver:
    """The part of NVIDIA's ``cuda.bindings.driver`` that hydroservo calls, with a device in plain Python."""

    CUresult = Status
    CUdevice_attribute = SimpleNamespace(CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT=16)
    CUfunction_attribute = SimpleNamespace(CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES=3)
    ARGUMENTS = 8
    SPILLED = 0

    def __init__(self) -> None:
        self.memory: dict[int, ctypes.Array[ctypes.c_char]] = {}
        self.loaded: list[str] = []

    def installed(self, patch: pytest.MonkeyPatch) -> "PtxDriver":
        """The driver in the place of the machine's, if it has one."""
        cuda_driver.device.cache_clear()
        patch.setattr(native, "READY", {})
        patch.setattr(cuda_driver, "driver", self)
        return self

    def cuInit(self, _flags: int) -> Any:  # noqa: N802
        return (Status.CUDA_SUCCESS,)

    def cuDeviceGet(self, number: int) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, number

    def cuDeviceGetAttribute(self, _which: int, _device: int) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, 1

    def cuDevicePrimaryCtxRetain(self, _device: int) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, object()

    def cuCtxSetCurrent(self, _context: Any) -> Any:  # noqa: N802
        return (Status.CUDA_SUCCESS,)

    def cuCtxSynchronize(self) -> Any:  # noqa: N802
        return (Status.CUDA_SUCCESS,)

    def cuGetErrorString(self, error: Status) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, error.name.encode()

    def cuMemAlloc(self, size: int) -> Any:  # noqa: N802
        numbers = ctypes.create_string_buffer(size)
        address = ctypes.addressof(numbers)
        self.memory[address] = numbers
        return Status.CUDA_SUCCESS, address

    def cuMemFree(self, address: int) -> Any:  # noqa: N802
        del self.memory[address]
        return (Status.CUDA_SUCCESS,)

    def cuMemcpyHtoD(self, there: int, here: int, size: int) -> Any:  # noqa: N802
        ctypes.memmove(there, here, size)
        return (Status.CUDA_SUCCESS,)

    def cuMemcpyDtoH(self, here: int, there: int, size: int) -> Any:  # noqa: N802
        ctypes.memmove(here, there, size)
        return (Status.CUDA_SUCCESS,)

    def cuModuleLoadData(self, code: bytes) -> Any:  # noqa: N802
        assert code.endswith(b"\0")
        self.loaded.append(code[:-1].decode())
        return Status.CUDA_SUCCESS, self.loaded[-1]

    def cuModuleGetFunction(self, module: str, name: bytes) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, PtxKernel(module, name.decode())

    def cuFuncGetAttribute(self, _which: int, _kernel: PtxKernel) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, self.SPILLED

    def cuOccupancyMaxActiveBlocksPerMultiprocessor(self, *_: Any) -> Any:  # noqa: N802
        return Status.CUDA_SUCCESS, 1

    def cuLaunchKernel(self, kernel: PtxKernel, *given: Any) -> Any:  # noqa: N802
        (blocks, _, _, threads, *_), places = given, given[8]
        kernel.launch(blocks, threads, (ctypes.c_uint64 * self.ARGUMENTS).from_address(places))
        return (Status.CUDA_SUCCESS,)
