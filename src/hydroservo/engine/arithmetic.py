"""Gives compiled code the arithmetic on whole states: importing this module is enough.

For each type of state the text of a small function is written, with an expression for every number.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from numba import types
from numba.extending import overload

from hydroservo import states
from hydroservo.engine.jit import INLINE

__all__ = ["compiled_axpy", "compiled_factored", "compiled_misses", "compiled_scaled", "compiled_solved"]


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


@overload(states.nudge, strict=False, jit_options=INLINE)
def compiled_nudge(*_: types.Type) -> Callable[..., Any]:
    return states.nudge


@overload(states.factored, strict=False, jit_options=INLINE)
def compiled_factored(
    _system: types.Type, _t: types.Type, x: types.Type, *_: types.Type
) -> Callable[..., Any]:
    """``states.factored`` for states of one type, without loops: a variable for each number of the matrix."""
    namespace: dict[str, Any] = {"nudge": states.nudge}
    paths = tuple(places(x))
    n = len(paths)
    lines = ["least = 1.0 / h"]
    for j, path in enumerate(paths):
        marked = {f"x.{path}": f"x.{path} + change"}
        lines.append(f"change = nudge(x.{path}, f.{path}, h)")
        lines.append(f"moved = system.deriv(t, {made(x, ('x',), '{}', namespace, marked)}, u)")
        for i, row in enumerate(paths):
            lines.append(f"a{i}_{j} = {'least' if i == j else 0.0} - (moved.{row} - f.{row}) / change")
    for k in range(n):
        lines.append(f"a{k}_{k} = 1.0 / a{k}_{k}")
        for i in range(k + 1, n):
            lines.append(f"a{i}_{k} = a{i}_{k} * a{k}_{k}")
            lines += [f"a{i}_{j} = a{i}_{j} - a{i}_{k} * a{k}_{j}" for j in range(k + 1, n)]
    matrix = ", ".join(f"a{i}_{j}" for i in range(n) for j in range(n))
    return written("system, t, x, u, f, h", f"({matrix},)", namespace, lines)


@overload(states.solved, strict=False, jit_options=INLINE)
def compiled_solved(_matrix: types.Type, k: types.Type) -> Callable[..., Any]:
    """``states.solved`` for states of one type, without loops."""
    namespace: dict[str, Any] = {}
    paths = tuple(places(k))
    n = len(paths)
    lines = [f"z{i} = k.{path}" for i, path in enumerate(paths)]
    for i in range(n):
        lines += [f"z{i} = z{i} - matrix[{n * i + j}] * z{j}" for j in range(i)]
    for i in reversed(range(n)):
        lines += [f"z{i} = z{i} - matrix[{n * i + j}] * z{j}" for j in range(i + 1, n)]
        lines.append(f"z{i} = z{i} * matrix[{n * i + i}]")
    solution = {f"k.{path}": f"z{i}" for i, path in enumerate(paths)}
    return written("matrix, k", made(k, ("k",), "{}", namespace, solution), namespace, lines)


def places(kind: types.Type, prefix: str = "") -> Iterator[str]:
    """The dotted path of each number of a state."""
    for field, part in zip(kind.fields, kind.types, strict=True):
        if isinstance(part, types.BaseNamedTuple):
            yield from places(part, f"{prefix}{field}.")
        else:
            yield prefix + field


def made(
    kind: types.Type,
    names: Sequence[str],
    number: str,
    namespace: dict[str, Any],
    instead: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """The text that makes a state, each number by the expression ``number`` of those of the states named.

    ``instead`` has other expressions for some of them, by the path of the first.
    """
    if not isinstance(kind, types.BaseNamedTuple):
        return instead.get(names[0], number.format(*names))
    name = f"T{len(namespace)}"
    namespace[name] = kind.instance_class
    inner = [
        made(part, [f"{one}.{field}" for one in names], number, namespace, instead)
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


def written(
    arguments: str, expression: str, namespace: dict[str, Any], lines: Sequence[str] = ()
) -> Callable[..., Any]:
    body = "\n    ".join([*lines, f"return {expression}"])
    exec(f"def function({arguments}):\n    {body}", namespace)  # text made of field names alone
    function: Callable[..., Any] = namespace["function"]
    return function
