"""Makes block methods and the functions of ops callable from compiled code.

Python finds a block's methods natively. Here numba is taught to do the same: a method call on any
NamedTuple resolves to the class's own function, forced inline. The functions of ops are compiled from
their text, but for those that are one machine instruction or read a number's bits.
"""

import math
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import FunctionType
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.errors import NumbaError as CompileError
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_builtin, overload

from hydroservo import ops
from hydroservo.ops import basic, binary

__all__ = ["INLINE", "CompileError", "compiled", "reason"]

INLINE = {"forceinline": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


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


ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
BIASED_ROUNDER = basic.ROUNDER + 1023.0  # leaves a whole number plus the bias in the lowest bits


def exponent(x: float) -> float:
    return float((bits(x) - ROOT_HALF_BITS) >> 52)


def mantissa(x: float) -> Any:
    b = bits(x)
    return from_bits(b - (((b - ROOT_HALF_BITS) >> 52) << 52))


def two_to(n: float) -> Any:
    return from_bits((bits(n + BIASED_ROUNDER) & 0x7FF) << 52)


INSTRUCTIONS: dict[Any, Any] = {  # numba compiles Python functions only, hence the lambdas around C's
    basic.absolute: lambda x: math.fabs(x),
    basic.copysign: lambda magnitude, x: math.copysign(magnitude, x),
    basic.sqrt: lambda x: math.sqrt(x),
    basic.floor: lambda x: np.floor(x),
    binary.exponent: exponent,
    binary.mantissa: mantissa,
    binary.two_to: two_to,
}

# Numba asks "if signature.recvr"; the type of a block without parameters has length 0 and must still count.
types.BaseNamedTuple.__bool__ = lambda _: True


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function compiled strictly: no fast-math, C's division, the GIL released."""
    dispatcher: Callable[..., Any] = njit(nogil=True, error_model="numpy")(function)
    return dispatcher


def reason(error: Exception) -> str:
    """Why code cannot be compiled, in one line: what numba says first of the innermost call, and where."""
    lines = [line.strip() for line in str(error).splitlines()]
    wrappers = ("Failed in nopython", "- Resolution failure", "None", "File ")
    said = next((line for line in lines if line and not line.startswith(wrappers)), "")
    place = next((line for line in lines if line.startswith("File ")), "").rstrip(":")
    return f"{said} ({place}); methods call only ops, each other and nested blocks"


@infer_getattr
class BlockMethods(AttributeTemplate):
    """Lets compiled code find the methods of a NamedTuple's class."""

    key = types.BaseNamedTuple

    def generic_resolve(self, block: Any, name: str) -> Any:
        method = vars(block.instance_class).get(name)
        if isinstance(method, FunctionType):
            return types.BoundFunction(method_template(method), block)
        return None


@cache
def method_template(method: FunctionType) -> type[AbstractTemplate]:
    inlined = njit(**INLINE)(method)

    class MethodTemplate(AbstractTemplate):
        key = method

        def generic(self, args: Any, kws: Any) -> Any:
            function = self.context.resolve_value_type(inlined)
            signature = function.get_call_type(self.context, (self.this, *args), kws)
            return signature.as_method()

    @lower_builtin(method, types.BaseNamedTuple, types.VarArg(types.Any))
    def lower(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        function = context.typing_context.resolve_value_type(inlined)
        full = function.get_call_type(context.typing_context, signature.args, {})
        call = context.get_function(function, full)
        context.add_linking_libs(getattr(call, "libs", ()))
        return call(builder, args)

    return MethodTemplate


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
