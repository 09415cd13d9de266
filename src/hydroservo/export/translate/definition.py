"""The text of a Python function, and whether it is what runs."""

import ast
import inspect
from collections import namedtuple
from types import FunctionType

from hydroservo.engine.lower.source import definition_of
from hydroservo.engine.lower.values import LoweringError

INHERITED = {"_asdict", "_make", "_replace"}  # what every NamedTuple class has
PLAIN_FIELD = type(namedtuple("Plain", "field").field)  # type: ignore[attr-defined]


class DoubtError(Exception):
    """Why a function cannot be translated from its text."""


def definition(origin: FunctionType) -> ast.FunctionDef:
    """A function's syntax tree, with the lines of its file.

    A method that was replaced, a decorator's wrapper or a file that changed in between are never taken for
    another: the tree's text gives the very code that runs.
    """
    code = origin.__code__
    if code.co_freevars:
        names = ", ".join(code.co_freevars)
        raise DoubtError(f"it is made by a decorator or inside another function, and uses {names} of that")
    if changed := {"__wrapped__", "__signature__"} & vars(origin).keys():
        raise DoubtError(f"a decorator gave it {min(changed)}, which hides what runs")
    try:
        node = definition_of(origin).node
    except LoweringError as error:
        raise DoubtError(str(error)) from None
    if isinstance(node, ast.Lambda):
        raise DoubtError("it is a lambda")
    return node


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
