"""The text of a Python function, and whether it is what runs."""

import ast
import inspect
from collections import namedtuple
from collections.abc import Iterator
from functools import lru_cache
from types import CodeType, FunctionType

__all__ = ["DoubtError", "changed_class", "definition", "own_method"]

INHERITED = {"_asdict", "_make", "_replace"}  # what every NamedTuple class has
PLAIN_FIELD = type(namedtuple("Plain", "field").field)  # type: ignore[attr-defined]


class DoubtError(Exception):
    """Why a function cannot be translated from its text."""


def definition(origin: FunctionType) -> ast.FunctionDef:
    """A function's syntax tree, with the lines of its file.

    The file's text is compiled once more, and must give the very code that runs: so a method that was
    replaced, a decorator's wrapper or a file that changed in between are never taken for another.

    Raises:
        DoubtError: the text is not there, is not what runs, or is not all that decides what it does.
    """
    code = origin.__code__
    if code.co_freevars:
        names = ", ".join(code.co_freevars)
        raise DoubtError(f"it is made by a decorator or inside another function, and uses {names} of that")
    if changed := {"__wrapped__", "__signature__"} & vars(origin).keys():
        raise DoubtError(f"a decorator gave it {min(changed)}, which hides what runs")
    return syntax_tree(code)


@lru_cache(maxsize=1024)
def syntax_tree(code: CodeType) -> ast.FunctionDef:
    """The syntax tree of what runs.

    Raises:
        DoubtError: the text is not there, or is not what runs.
    """
    try:
        lines, _ = inspect.findsource(code)
        found = definitions("".join(lines))
    except (OSError, SyntaxError, ValueError):
        raise DoubtError("its source is not available") from None
    made = found.get(code)
    if made is None:
        what = (
            "it is a lambda"
            if code.co_name == "<lambda>"
            else "the text of its file is not the code that runs"
        )
        raise DoubtError(what)
    return made


@lru_cache(maxsize=64)
def definitions(text: str) -> dict[CodeType, ast.FunctionDef]:
    """The functions that a file defines, by their code."""
    tree = ast.parse(text)
    places = {
        (node.name, min([node.lineno, *(one.lineno for one in node.decorator_list)])): node
        for node in functions(tree)
    }
    whole = compile(text, "text", "exec", dont_inherit=True)
    return {
        code: places[code.co_name, code.co_firstlineno]
        for code in codes(whole)
        if (code.co_name, code.co_firstlineno) in places
    }


def functions(node: ast.AST) -> Iterator[ast.FunctionDef]:
    """The functions in a tree, without a look at its expressions."""
    for one in ast.iter_child_nodes(node):
        if isinstance(one, ast.FunctionDef):
            yield one
        if not isinstance(one, ast.expr):
            yield from functions(one)


def codes(code: CodeType) -> Iterator[CodeType]:
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield one
            yield from codes(one)


def own_method(cls: type, name: str) -> FunctionType:
    """A method that a record's class has itself.

    Raises:
        DoubtError: it is inherited, or something else than a plain method.
    """
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
