"""Gives compiled code the arithmetic on whole states: importing this module is enough.

For each type of state the text of a small function is written, with an expression for every number.
"""

from collections.abc import Callable, Sequence
from typing import Any

from numba import types
from numba.extending import overload

from hydroservo import states
from hydroservo.engine.jit import INLINE

__all__ = ["compiled_axpy", "compiled_misses", "compiled_scaled"]


@overload(states.axpy, strict=False, jit_options=INLINE)
def compiled_axpy(x: types.Type, _h: types.Type, _k: types.Type) -> Callable[..., Any]:
    """``states.axpy`` for states of one type."""
    namespace: dict[str, Any] = {}
    return written("x, h, k", made(x, ("x", "k"), "{} + h * {}", namespace), namespace)


@overload(states.scaled, strict=False, jit_options=INLINE)
def compiled_scaled(_h: types.Type, k: types.Type) -> Callable[..., Any]:
    """``states.scaled`` for states of one type."""
    namespace: dict[str, Any] = {}
    return written("h, k", made(k, ("k",), "h * {}", namespace), namespace)


@overload(states.misses, strict=False, jit_options=INLINE)
def compiled_misses(error: types.Type, *_: types.Type) -> Callable[..., Any]:
    """``states.misses`` for states of one type."""
    names = ("error", "x", "y", "rate")
    return written(
        f"{', '.join(names)}, dt", summed(error, names, "miss({}, {}, {}, {}, dt)"), {"miss": states.miss}
    )


@overload(states.miss, strict=False, jit_options=INLINE)
def compiled_miss(*_: types.Type) -> Callable[..., Any]:
    return states.miss


def made(kind: types.Type, names: Sequence[str], number: str, namespace: dict[str, Any]) -> str:
    """The text that makes a state, each number by the expression ``number`` of those of the states named."""
    if not isinstance(kind, types.BaseNamedTuple):
        return number.format(*names)
    name = f"T{len(namespace)}"
    namespace[name] = kind.instance_class
    inner = [
        made(part, [f"{one}.{field}" for one in names], number, namespace)
        for field, part in zip(kind.fields, kind.types, strict=True)
    ]
    return f"{name}({', '.join(inner)})"


def summed(kind: types.Type, names: Sequence[str], number: str) -> str:
    """The text that adds an expression of each number, group by group as the interpreted function does."""
    if not isinstance(kind, types.BaseNamedTuple):
        return number.format(*names)
    inner = [
        summed(part, [f"{one}.{field}" for one in names], number)
        for field, part in zip(kind.fields, kind.types, strict=True)
    ]
    return f"({' + '.join(['0.0', *inner])})"


def written(arguments: str, expression: str, namespace: dict[str, Any]) -> Callable[..., Any]:
    exec(f"def function({arguments}): return {expression}", namespace)  # text made of field names alone
    function: Callable[..., Any] = namespace["function"]
    return function
