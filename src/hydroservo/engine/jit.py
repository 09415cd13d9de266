"""Makes block methods and the functions of ops callable from compiled code.

Python finds a block's methods natively. Here numba is taught to do the same: a method call on any
NamedTuple resolves to the class's own function, forced inline. Elementary functions map to C's; the
other functions of ops are compiled from their text.
"""

import math
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np
from numba import njit, types
from numba.core.errors import NumbaError as CompileError
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate
from numba.extending import infer_getattr, lower_builtin, overload

from hydroservo import ops

__all__ = ["INLINE", "CompileError", "compiled", "reason"]

INLINE = {"forceinline": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

ELEMENTARY = {  # numba compiles Python functions only, hence the lambdas around C's
    ops.absolute: lambda x: math.fabs(x),
    ops.copysign: lambda magnitude, x: math.copysign(magnitude, x),
    ops.sqrt: lambda x: math.sqrt(x),
    ops.sin: lambda x: math.sin(x),
    ops.cos: lambda x: math.cos(x),
    ops.tanh: lambda x: math.tanh(x),
    ops.floor: lambda x: np.floor(x),
    ops.power: lambda x, exponent: math.pow(x, exponent),
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


def register_ops() -> None:
    for name in ops.__all__:
        function = getattr(ops, name)
        implementation = ELEMENTARY.get(function, function)
        overload(function, strict=False, jit_options=INLINE)(lambda *_, f=implementation: f)


register_ops()
