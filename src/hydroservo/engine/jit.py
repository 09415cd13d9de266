"""Makes block methods and the functions of ops callable from compiled code.

Python finds a block's methods natively. Here numba is taught to do the same: a method call on any
NamedTuple resolves to the class's own function, forced inline. The functions of ops are compiled from
their text, but for those that are one machine instruction or read a number's bits.
"""

import math
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from traceback import walk_tb
from types import FunctionType
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.errors import NumbaError
from numba.core.targetconfig import ConfigStack
from numba.core.typing import signature as typed
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_global
from numba.extending import infer_getattr, intrinsic, lower_builtin, overload
from numba.np import arrayobj

from hydroservo import ops
from hydroservo.engine import flat
from hydroservo.ops import basic, binary

__all__ = ["CONTRACT", "INLINE", "WAY_OUT", "method_template", "places", "reason", "said"]

CONTRACT = {"contract"}  # lets LLVM fuse a multiplication with an addition
INLINE = {
    "forceinline": True,
    "error_model": "numpy",
    "boundscheck": True,  # of a block's own arrays; an index beyond them stops the run
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,  # also where others' compiled code, which counts references to arrays, called it first
}


@intrinsic
def bits(_context: Any, _x: Any) -> Any:
    """The bits of a float as an integer."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def from_bits(_context: Any, _n: Any) -> Any:
    """The float that has these bits."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), generate


@intrinsic
def root(_context: Any, _x: Any) -> Any:
    """The processor's square root: C's would set errno, which takes a branch."""

    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        double = ir.DoubleType()
        return builder.call(builder.module.declare_intrinsic("llvm.sqrt", [double]), args)

    return types.float64(types.float64), generate


DOUBLE = 8  # bytes
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
BIASED_ROUNDER = basic.ROUNDER + 2046.0  # leaves a whole number plus twice the bias in the lowest bits


def exponent(x: float) -> float:
    return float((bits(x) - ROOT_HALF_BITS) >> 52)


def mantissa(x: float) -> Any:
    b = bits(x)
    return from_bits(b - (((b - ROOT_HALF_BITS) >> 52) << 52))


def scaled(x: float, n: float) -> Any:
    """In two steps of half the exponent each, of which the last alone can round."""
    biased = bits(n + BIASED_ROUNDER)
    half = biased >> 1
    return x * from_bits(half << 52) * from_bits((biased - half) << 52)


INSTRUCTIONS: dict[Any, Any] = {  # numba compiles Python functions only, hence the lambdas around C's
    basic.absolute: lambda x: math.fabs(x),
    basic.copysign: lambda magnitude, x: math.copysign(magnitude, x),
    basic.sqrt: lambda x: root(x),
    basic.floor: lambda x: np.floor(x),
    binary.exponent: exponent,
    binary.mantissa: mantissa,
    binary.scaled: scaled,
}

# Numba asks "if signature.recvr"; the type of a block without parameters has length 0 and must still count.
types.BaseNamedTuple.__bool__ = lambda _: True


WAY_OUT = "methods call only ops, each other and nested blocks, and give every field"
WRAPPERS = ("Failed in nopython", "- Resolution failure", "None", "File ")
NO_FUNCTION = "No implementation of function "  # the call that has none stands in a line of its own below
NO_MEMORY = "NRT required but not enabled"
PLACE = re.compile(
    r"(?: at|[Rr]aised from) (?P<at>\S.*) \((?P<row>\d+)\)$|^ *File \"(?P<file>.*)\", line (?P<line>\d+):$",
    re.MULTILINE,
)


def reason(error: Exception) -> str:
    """Why code cannot be compiled, in one line: what numba says first of the innermost call, and where."""
    lines = (line.strip() for line in str(error).splitlines())
    place = next((line for line in lines if line.startswith("File ")), "").rstrip(":")
    return f"{said(error)} ({place}); {WAY_OUT}" if place else f"{said(error)}; {WAY_OUT}"


def said(error: Exception) -> str:
    """What numba says of the innermost call that it cannot compile."""
    lines = [line.strip() for line in str(error).splitlines()]
    first = next((line for line in lines if line and not line.startswith(WRAPPERS)), "")
    if first == NO_MEMORY:
        return "a list, a dict or a text needs memory, of which compiled code has none"
    if first.startswith(NO_FUNCTION):
        call = next((line.removeprefix(">>> ") for line in lines if line.startswith(">>> ")), "")
        return f"compiled code has no {call}" if call else first
    kind = "" if isinstance(error, NumbaError) else f"{type(error).__name__}: "
    return f"{kind}{plain(PLACE.sub('', first).rstrip('. '))}"


def places(error: Exception) -> list[tuple[str, int]]:
    """The files and lines that code which cannot be compiled goes through, from the inside out.

    Where numba names none, the method that it stumbled over.
    """
    found = PLACE.finditer(str(error))
    named = [(absolute(one["at"] or one["file"]), int(one["row"] or one["line"])) for one in found]
    frames = (frame for frame, _ in walk_tb(error.__traceback__) if frame.f_code.co_filename == __file__)
    tried = [frame.f_locals["inlined"] for frame in frames if "inlined" in frame.f_locals]
    codes = [method.py_func.__code__ for method in reversed(tried)]
    return named + [(absolute(code.co_filename), code.co_firstlineno) for code in codes]


def absolute(file: str) -> str:
    return str(Path(file).absolute())


@infer_getattr
class BlockMethods(AttributeTemplate):
    """Lets compiled code find the methods of a NamedTuple's class."""

    key = types.BaseNamedTuple

    def generic_resolve(self, block: Any, name: str) -> Any:
        method = vars(block.instance_class).get(name)
        if isinstance(method, FunctionType):
            return types.BoundFunction(method_template(method, fast_math()), block)
        return None


def fast_math() -> frozenset[str]:
    """The flags of the function that is being compiled; what it calls takes them over."""
    flags = ConfigStack().top_or_none()
    return frozenset(flags.fastmath.flags) if flags is not None and flags.fastmath else frozenset()


@cache
def method_template(method: FunctionType, _flags: frozenset[str]) -> type[AbstractTemplate]:
    """What numba has to know to call a method, compiled with these fast-math flags."""
    inlined = njit(**INLINE)(method)

    class MethodTemplate(AbstractTemplate):
        key = inlined

        def generic(self, args: Any, kws: Any) -> Any:
            function = self.context.resolve_value_type(inlined)
            signature = function.get_call_type(self.context, (self.this, *args), kws)
            return signature.as_method()

    @lower_builtin(inlined, types.BaseNamedTuple, types.VarArg(types.Any))
    def lower(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        function = context.typing_context.resolve_value_type(inlined)
        full = function.get_call_type(context.typing_context, signature.args, {})
        call = context.get_function(function, full)
        context.add_linking_libs(getattr(call, "libs", ()))
        return call(builder, args)

    return MethodTemplate


PLAIN = (  # what numba says, and what it means to who wrote a block
    (
        r"Untyped global name '(\w+)': .*<class 'function'>.*",
        r"\1 is a function of a module, which compiled code cannot call: make it a method of the block",
    ),
    (r"Unknown attribute '(\w+)' of type (\w+)\(.*", r"\1 is no field and no method of \2"),
)


def plain(said: str) -> str:
    """What numba says, in the words of who wrote the block."""
    for pattern, words in PLAIN:
        said = re.sub(pattern, words, said)
    return said


@infer_global(flat.array_at)
class ArrayAt(AbstractTemplate):
    """The type of an array at an address."""

    def generic(self, args: Any, _kws: Any) -> Any:
        return typed(types.Array(types.float64, len(args[1]), "C"), *args)


@lower_builtin(flat.array_at, types.Integer, types.BaseTuple)
def lower_array_at(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """An array that owns nothing: kernels allocate and free no memory."""
    array = arrayobj.make_array(signature.return_type)(context, builder)
    lengths = cgutils.unpack_tuple(builder, args[1])
    strides = [context.get_constant(types.intp, DOUBLE)]
    for length in reversed(lengths[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    data = builder.inttoptr(args[0], ir.DoubleType().as_pointer())
    arrayobj.populate_array(array, data, lengths, strides, DOUBLE, meminfo=None)
    return array._getvalue()


def ops_functions() -> Iterator[FunctionType]:
    """Every function that the modules of ops define."""
    for module in iter_modules(ops.__path__, "hydroservo.ops."):
        for value in vars(import_module(module.name)).values():
            if isinstance(value, FunctionType) and value.__module__ == module.name:
                yield value


def register_ops() -> None:
    for function in ops_functions():
        implementation = INSTRUCTIONS.get(function, function)
        overload(function, strict=False, jit_options=INLINE)(lambda *_, f=implementation: f)


register_ops()
