"""The text of a function as a tree: that which was loaded, word for word."""

import ast
import linecache
from collections.abc import Iterator
from functools import cache
from itertools import chain
from types import CodeType, FunctionType
from typing import Any, NamedTuple

from hydroservo import ops
from hydroservo.engine.lower.values import LoweringError

Place = tuple[int, str]  # the first line of a function, and its name

NOTHING: tuple[Any, list[CodeType]] = (None, [])
UNIFORM, NORMAL = "uniform(seed, stream, index)", "normal(seed, stream, index)"
SAME = {  # functions of Python and numpy, by the name of their equal in ops
    "abs": "absolute",
    "amax": "maximum",
    "amin": "minimum",
    "ceil": "floor",
    "exp": "power(math.e, x)",
    "fabs": "absolute",
    "fmod": "floor",
    "gauss": NORMAL,
    "max": "maximum",
    "min": "minimum",
    "normal": NORMAL,
    "normalvariate": NORMAL,
    "pow": "power",
    "rand": UNIFORM,
    "randn": NORMAL,
    "random": UNIFORM,
    "rint": "nearest",
    "round": "nearest",
    "standard_normal": NORMAL,
    "uniform": UNIFORM,
}
TABLE = "keep the table in a field that is a hydroservo.curve.Curve, and call its value(x)"
VECTOR = "make a record of as many floats with hydroservo.vectors.vector"
OTHERS = {"interp": TABLE} | dict.fromkeys(
    ("array", "asarray", "dot", "empty", "eye", "matmul", "ones", "roll", "zeros"), VECTOR
)


class Definition(NamedTuple):
    """A function as it is defined."""

    node: ast.FunctionDef | ast.Lambda
    arguments: ast.arguments
    body: list[ast.stmt]
    local: frozenset[str]  # names that are its own


KNOWN: dict[CodeType, Definition] = {}


def definition_of(function: FunctionType) -> Definition:
    """The definition of a function."""
    code = function.__code__
    if code not in KNOWN:
        KNOWN[code] = found_definition(function, code)
    return KNOWN[code]


def found_definition(function: FunctionType, code: CodeType) -> Definition:
    file = code.co_filename
    for in_cell in (False, True):
        found = functions_in(file, "".join(linecache.getlines(file, function.__globals__)), in_cell)
        node, loaded = found.get((code.co_firstlineno, code.co_name), NOTHING)
        if content(code) in map(content, loaded):
            body = [ast.Return(node.body, lineno=node.lineno)] if isinstance(node, ast.Lambda) else node.body
            return Definition(node, node.args, body, frozenset(code.co_varnames + code.co_cellvars))
        linecache.checkcache(file)
    raise LoweringError(f"the text of {function.__name__} in {file} is not the code that runs")


@cache
def functions_in(file: str, text: str, in_cell: bool) -> dict[Place, tuple[Any, list[CodeType]]]:
    """The functions in a text, each as a tree and as Python may have compiled it."""
    try:
        tree = ast.parse(text)
        alone = [ast.Module([one], []) for one in tree.body if in_cell]
        modules = [compile(one, file, "exec", dont_inherit=True) for one in (tree, *alone)]
    except SyntaxError:
        return {}
    codes: dict[Place, list[CodeType]] = {}
    for place, code in chain.from_iterable(map(codes_in, modules)):
        codes.setdefault(place, []).append(code)
    nodes = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda))
    placed = ((place_of(node), node) for node in nodes)
    return {place: (node, codes[place]) for place, node in placed if place in codes}


def place_of(node: ast.FunctionDef | ast.Lambda) -> Place:
    if isinstance(node, ast.Lambda):
        return node.lineno, "<lambda>"
    return min([node.lineno, *(one.lineno for one in node.decorator_list)]), node.name


def codes_in(code: CodeType) -> Iterator[tuple[Place, CodeType]]:
    """The code of each function in some code."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield (constant.co_firstlineno, constant.co_name), constant
            yield from codes_in(constant)


def content(code: CodeType) -> tuple[Any, ...]:
    """Everything that decides what a function does, wherever it stands."""
    constants = [content(value) if isinstance(value, CodeType) else value for value in code.co_consts]
    arguments = (code.co_argcount, code.co_kwonlyargcount, code.co_varnames, code.co_freevars)
    return code.co_code, repr(constants), code.co_names, arguments


@cache
def assigned(loop: ast.For | ast.While) -> tuple[str, ...]:
    """The names that a loop gives new values."""
    return tuple(dict.fromkeys(node.id for node in names_in(loop) if isinstance(node.ctx, ast.Store)))


@cache
def read_after(loop: ast.For | ast.While, body: tuple[ast.stmt, ...]) -> frozenset[str]:
    """The names that a function reads after a loop in its body."""
    end = loop.end_lineno or loop.lineno
    nodes = (node for statement in body for node in names_in(statement))
    return frozenset(node.id for node in nodes if node.lineno > end and isinstance(node.ctx, ast.Load))


def names_in(tree: ast.AST) -> Iterator[ast.Name]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Name))


def hint_for(called: Any) -> str:
    """What to write instead of a function; "" where nothing serves."""
    name = str(getattr(called, "__name__", ""))
    same = SAME.get(name, name)
    if same.partition("(")[0] in ops.__all__:
        return f"use ops.{same}"
    return OTHERS.get(name, "")
