"""The text of a function as a tree: that which was loaded, word for word."""

import ast
import inspect
import linecache
from collections import namedtuple
from collections.abc import Iterator
from functools import cache
from itertools import chain
from types import CodeType, FunctionType
from typing import Any

from hydroservo.core import ops

Place = tuple[int, str]  # the first line of a function, and its name

ABSENT: tuple[Any, list[CodeType]] = (None, [])
INHERITED = {"_asdict", "_make", "_replace"}  # what every NamedTuple class has
PLAIN_FIELD = type(namedtuple("Plain", "field").field)  # type: ignore[attr-defined]
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
TABLE = "keep the table in a field that is a hydroservo.core.curve.Curve, and call its value(x)"
VECTOR = "make a record of as many floats with hydroservo.core.vectors.vector"
OTHERS = {"interp": TABLE} | dict.fromkeys(
    ("array", "asarray", "dot", "empty", "eye", "matmul", "ones", "roll", "zeros"), VECTOR
)


class DoubtError(Exception):
    """Why a function cannot be read from its text."""


KNOWN: dict[CodeType, ast.FunctionDef] = {}


def definition(function: FunctionType) -> ast.FunctionDef:
    """A function's syntax tree, with the lines of its file.

    A method that was replaced, a decorator's wrapper or a file that changed in between are never taken for
    another: the tree's text gives the very code that runs.
    """
    if changed := {"__wrapped__", "__signature__"} & vars(function).keys():
        raise DoubtError(f"a decorator gave it {min(changed)}, which hides what runs")
    code = function.__code__
    if code not in KNOWN:
        KNOWN[code] = loaded_definition(function, code)
    return KNOWN[code]


def loaded_definition(function: FunctionType, code: CodeType) -> ast.FunctionDef:
    file = code.co_filename
    for in_cell in (False, True):
        functions = functions_in(file, "".join(linecache.getlines(file, function.__globals__)), in_cell)
        node, loaded = functions.get((code.co_firstlineno, code.co_name), ABSENT)
        if function_content(code) in map(function_content, loaded):
            if isinstance(node, ast.Lambda):
                raise DoubtError("it is a lambda")
            tree: ast.FunctionDef = node
            return tree
        linecache.checkcache(file)
    raise DoubtError(f"the text of {function.__name__} in {file} is not the code that runs")


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
    placed = ((source_line(node), node) for node in nodes)
    return {place: (node, codes[place]) for place, node in placed if place in codes}


def source_line(node: ast.FunctionDef | ast.Lambda) -> Place:
    if isinstance(node, ast.Lambda):
        return node.lineno, "<lambda>"
    return min([node.lineno, *(one.lineno for one in node.decorator_list)]), node.name


def codes_in(code: CodeType) -> Iterator[tuple[Place, CodeType]]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield (constant.co_firstlineno, constant.co_name), constant
            yield from codes_in(constant)


def function_content(code: CodeType) -> tuple[Any, ...]:
    """Everything that decides what a function does, wherever it stands."""
    constants = [
        function_content(value) if isinstance(value, CodeType) else value for value in code.co_consts
    ]
    arguments = (code.co_argcount, code.co_kwonlyargcount, code.co_varnames, code.co_freevars)
    return code.co_code, repr(constants), code.co_names, arguments


def hint_for(called: Any) -> str:
    """What to write instead of a function; "" where nothing serves."""
    name = str(getattr(called, "__name__", ""))
    same = SAME.get(name, name)
    if same.partition("(")[0] in ops.__all__:
        return f"use ops.{same}"
    return OTHERS.get(name, "")


def own_method(cls: type, name: str) -> FunctionType:
    """A method that a record's class has itself."""
    found = vars(cls).get(name)
    if isinstance(found, FunctionType) and name not in INHERITED:
        return found
    if not hasattr(cls, name):
        raise DoubtError(f"{cls.__name__} has no method {name}")
    what = "inherited" if found is None or name in INHERITED else type(found).__name__
    raise DoubtError(f"{name} of {cls.__name__} is not a method of its own ({what})")


def changed_class(cls: type) -> str:
    """What a record's class does otherwise than a NamedTuple; "" for nothing.

    A class that derives from another record may hide its fields behind values of its own, and compute in
    ``__new__``; neither can be seen where a field is read or a record made.
    """
    if "__getattribute__" in vars(cls) or "__getattr__" in vars(cls):
        return "its own way to read attributes"
    made = getattr(cls.__new__, "__globals__", {}).get("__name__", "")
    if not str(made).startswith("namedtuple_"):
        return "its own __new__"
    fields: tuple[str, ...] = getattr(cls, "_fields", ())
    hidden = [name for name in fields if type(inspect.getattr_static(cls, name)) is not PLAIN_FIELD]
    return f"something else in place of its field {hidden[0]}" if hidden else ""
