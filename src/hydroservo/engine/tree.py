"""Arithmetic and access on nested states, for interpreted and compiled code alike.

Compiled code cannot loop over the fields of a NamedTuple, so for each state type the text of a small
function is written and compiled once.
"""

from collections.abc import Callable, Sequence
from typing import Any

from numba import types
from numba.extending import overload

from hydroservo.block import Block
from hydroservo.engine.jit import INLINE

__all__ = ["axpy", "reader", "recorder"]


def axpy(x: Block, h: float, k: Block) -> Block:
    """x + h k, number by number over two states of one type."""
    if isinstance(x, tuple):
        return type(x)(*[axpy(a, h, b) for a, b in zip(x, k, strict=True)])
    return x + h * k


@overload(axpy, strict=False, jit_options=INLINE)
def compiled_axpy(x: types.Type, _h: types.Type, _k: types.Type) -> Callable[..., Any]:
    namespace: dict[str, Any] = {}
    text = axpy_text(x, "x", "k", namespace)
    return written(f"def axpy(x, h, k): return {text}", namespace, "axpy")


def axpy_text(kind: types.Type, x: str, k: str, namespace: dict[str, Any]) -> str:
    if not isinstance(kind, types.BaseNamedTuple):
        return f"{x} + h * {k}"
    name = f"T{len(namespace)}"
    namespace[name] = kind.instance_class
    inner = [
        axpy_text(part, f"{x}.{field}", f"{k}.{field}", namespace)
        for field, part in zip(kind.fields, kind.types, strict=True)
    ]
    return f"{name}({', '.join(inner)})"


def recorder(paths: Sequence[str]) -> Callable[..., None]:
    """A function ``record(out, row, s)`` that writes the numbers at these paths of a state."""
    lines = [f"    out[row, {column}] = s.{path}" for column, path in enumerate(paths)]
    return written("\n".join(["def record(out, row, s):", *lines, "    return None"]), {}, "record")


def reader(paths: Sequence[str | None]) -> Callable[..., Any]:
    """A function ``read(s)`` that returns the numbers at these paths of a state; nan for None."""
    items = ", ".join("nan" if path is None else f"s.{path}" for path in paths)
    return written(f"def read(s): return ({items},)", {"nan": float("nan")}, "read")


def written(text: str, namespace: dict[str, Any], name: str) -> Callable[..., Any]:
    exec(text, namespace)  # text made above from field names alone
    function: Callable[..., Any] = namespace[name]
    return function
