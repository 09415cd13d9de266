"""The arithmetic on whole states as the text of functions, each for one type of state.

Neither compiled code nor C can loop over the fields of a NamedTuple, so each text has an expression for every
number. The export translates the same texts that the engine compiles.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import FunctionType, MappingProxyType
from typing import Any

from hydroservo.core import block, states
from hydroservo.engine.flat import text_function
from hydroservo.language.body import Body
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import Function, Record, Translator, Type


def axpy_text(shape: Record) -> FunctionType:
    """``states.axpy`` for states of one type."""
    namespace: dict[str, Any] = {}
    return defined(states.axpy, "x, h, k", made(shape, ("x", "k"), "{} + h * {}", namespace), namespace)


def scaled_text(shape: Record) -> FunctionType:
    """``states.scaled`` for states of one type."""
    namespace: dict[str, Any] = {}
    return defined(states.scaled, "h, k", made(shape, ("k",), "h * {}", namespace), namespace)


def misses_text(shape: Record) -> FunctionType:
    """``states.misses`` for states of one type."""
    names = ("error", "x", "y", "rate")
    total = summed_text(shape, names, "miss({}, {}, {}, {}, dt)")
    return defined(states.misses, f"{', '.join(names)}, dt", total, {"miss": states.miss})


def factored_text(shape: Record) -> FunctionType:
    """``states.factored`` for states of one type, without loops: a variable for each number of the matrix."""
    namespace: dict[str, Any] = {"nudge": states.nudge}
    paths = tuple(places(shape))
    n = len(paths)
    lines = ["least = 1.0 / h"]
    for j, path in enumerate(paths):
        marked = {f"x.{path}": f"x.{path} + change"}
        lines.append(f"change = nudge(x.{path}, f.{path}, h)")
        lines.append(f"moved = system.deriv(t, {made(shape, ('x',), '{}', namespace, marked)}, u)")
        for i, row in enumerate(paths):
            lines.append(f"a{i}_{j} = {'least' if i == j else 0.0} - (moved.{row} - f.{row}) / change")
    for k in range(n):
        lines.append(f"a{k}_{k} = 1.0 / a{k}_{k}")
        for i in range(k + 1, n):
            lines.append(f"a{i}_{k} = a{i}_{k} * a{k}_{k}")
            lines += [f"a{i}_{j} = a{i}_{j} - a{i}_{k} * a{k}_{j}" for j in range(k + 1, n)]
    matrix = ", ".join(f"a{i}_{j}" for i in range(n) for j in range(n))
    return defined(states.factored, "system, t, x, u, f, h", f"({matrix},)", namespace, lines)


def solved_text(shape: Record) -> FunctionType:
    """``states.solved`` for states of one type, without loops."""
    namespace: dict[str, Any] = {}
    paths = tuple(places(shape))
    n = len(paths)
    lines = [f"z{i} = k.{path}" for i, path in enumerate(paths)]
    for i in range(n):
        lines += [f"z{i} = z{i} - matrix[{n * i + j}] * z{j}" for j in range(i)]
    for i in reversed(range(n)):
        lines += [f"z{i} = z{i} - matrix[{n * i + j}] * z{j}" for j in range(i + 1, n)]
        lines.append(f"z{i} = z{i} * matrix[{n * i + i}]")
    solution = {f"k.{path}": f"z{i}" for i, path in enumerate(paths)}
    return defined(
        states.solved, "matrix, k", made(shape, ("k",), "{}", namespace, solution), namespace, lines
    )


def overlaid_text(shape: Record, given: Record) -> FunctionType:
    """``states.overlaid`` for states of one type and groups of another."""
    namespace: dict[str, Any] = {}
    instead = {f"x.{path}": f"given.{path}" for path in places(given)}
    return defined(states.overlaid, "x, given", made(shape, ("x",), "{}", namespace, instead), namespace)


def estimates_text(shape: Record) -> FunctionType:
    """``block.estimates_in`` for states of one type."""
    return defined(block.estimates_in, "state", holder(shape, "state"), {})


def holder(shape: Record, path: str) -> str:
    """The path of the first state that holds d1 and d2; empty if none does."""
    if {"d1", "d2"} <= set(shape.fields):
        return path
    inner = (
        holder(part, f"{path}.{field}") for field, part in shape.fields.items() if isinstance(part, Record)
    )
    return next(filter(None, inner), "")


def model_text(shape: Record) -> FunctionType:
    """``block.model_in`` for laws of one type."""
    path = "controller"
    while "model" not in shape.fields:
        inner = shape.fields["controller"]
        if not isinstance(inner, Record):
            raise KeyError(path)
        shape, path = inner, f"{path}.controller"
    return defined(block.model_in, "controller", f"{path}.model", {})


def places(shape: Record, prefix: str = "") -> Iterator[str]:
    """The dotted path of each number of a state."""
    for field, part in shape.fields.items():
        if isinstance(part, Record):
            yield from places(part, f"{prefix}{field}.")
        else:
            yield prefix + field


def made(
    shape: Type,
    names: Sequence[str],
    number: str,
    namespace: dict[str, Any],
    instead: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """The text that makes a state, each number by the expression ``number`` of those of the states named.

    ``instead`` has other expressions for some of them, by the path of the first.
    """
    if not isinstance(shape, Record):
        return instead.get(names[0], number.format(*names))
    name = f"T{len(namespace)}"
    namespace[name] = shape.cls
    inner = [
        made(part, [f"{one}.{field}" for one in names], number, namespace, instead)
        for field, part in shape.fields.items()
    ]
    return f"{name}({', '.join(inner)})"


def summed_text(shape: Type, names: Sequence[str], number: str) -> str:
    """The text that adds an expression of each number, group by group as the interpreted function does."""
    if not isinstance(shape, Record):
        return number.format(*names)
    inner = [
        summed_text(part, [f"{one}.{field}" for one in names], number) for field, part in shape.fields.items()
    ]
    return f"({' + '.join(['0.0', *inner])})"


def defined(
    origin: Any, arguments: str, expression: str, namespace: dict[str, Any], lines: Sequence[str] = ()
) -> FunctionType:
    """A function that returns an expression after some lines, in place of another one."""
    name = origin.__name__
    body = "\n    ".join([*lines, f"return {expression}"])
    namespace["__name__"] = origin.__module__
    function = text_function(f"def {name}({arguments}):\n    {body}\n", namespace, name)
    function.__doc__ = origin.__doc__
    return function


Made = Callable[[Translator, Sequence[Type]], Function]


def for_records(text: Callable[..., FunctionType], *numbers: int) -> Made:
    """What translates a function by its text for the types of some of its arguments."""

    def made(translator: Translator, arguments: Sequence[Type]) -> Function:
        shapes = [record_of(arguments[number]) for number in numbers]
        return Body(translator, text(*shapes), arguments, None).translated()

    return made


def record_of(kind: Type) -> Record:
    """A type as that of a state.

    Raises:
        TranslationError: it is another one.
    """
    if not isinstance(kind, Record):
        raise TranslationError("arithmetic on states takes whole states, not numbers")
    return kind


TRANSLATED: Mapping[Any, Made] = {  # each by the types of these arguments
    states.axpy: for_records(axpy_text, 0),
    states.scaled: for_records(scaled_text, 1),
    states.misses: for_records(misses_text, 0),
    states.factored: for_records(factored_text, 2),
    states.solved: for_records(solved_text, 1),
    states.overlaid: for_records(overlaid_text, 0, 1),
    block.estimates_in: for_records(estimates_text, 0),
    block.model_in: for_records(model_text, 0),
}
