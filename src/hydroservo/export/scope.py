"""The names of a function that is being translated, and where its statements go."""

import ast
import inspect
import textwrap
from collections.abc import Callable, Set
from types import FunctionType
from typing import Any

from hydroservo.errors import LoopError
from hydroservo.export.bindings import bound_names, changing_names
from hydroservo.export.names import identifier
from hydroservo.export.terms import (
    BOOL,
    INT,
    Assign,
    Bound,
    Call,
    Expression,
    Function,
    Known,
    Let,
    Member,
    Python,
    Several,
    Statement,
    Table,
    Type,
    Variable,
    Whole,
)

__all__ = ["WAY_OUT", "Scope", "TranslationError", "Value", "place", "whole"]

LARGEST_WHOLE = 2**53  # up to here a float holds every whole number

Value = Expression | Known | Table | Python | Bound | Several

WAY_OUT = "a law that is exported calls only ops, its own methods and those of nested blocks"


class TranslationError(LoopError):
    """A method that has no equal in C; the message names file, line and the way out."""


def place(function: Any, line: int = 0) -> str:
    """The file of a Python function and a line in it."""
    code = function.__code__
    return f"{code.co_filename}, line {line or code.co_firstlineno}"


class Scope:
    """One Python function on its way to C.

    Making one raises :class:`TranslationError` where the function's text is not there.

    Attributes:
        origin: the Python function.
        tree: its syntax tree, with the lines of its file.
        function: its equal in C, as far as it is translated.
        changing: the names that get a variable, for their values change.
        environment: what each name stands for.
        certain: the changing locals that have a value by now.
        block: where statements go.

    Args:
        origin: the Python function.
        name: of its equal in C.
        owner: the class whose method it is.
        local_name: finds a free name for a local, from a wish and those that the function has given.
    """

    def __init__(
        self, origin: FunctionType, name: str, owner: type | None, local_name: Callable[[str, Set[str]], str]
    ) -> None:
        self.origin = origin
        self.tree = parsed(origin)
        self.function = Function(name, [], origin=origin, owner=owner)
        self.changing = changing_names(self.tree)
        self.local_name = local_name
        self.taken: set[str] = set()
        arguments = [argument.arg for argument in self.tree.args.args]
        wanted = dict.fromkeys([*arguments, *bound_names(self.tree)])
        self.in_c = {one: self.fresh(identifier(one)) for one in wanted}
        self.environment: dict[str, Value] = {}
        self.certain: set[str] = set()
        self.block: list[Statement] = self.function.body

    def parameter(self, name: str, kind: Type) -> None:
        """A parameter; one that the function assigns to gets a local of its own."""
        given = kind if isinstance(kind, (Known, Table)) else Variable(kind, self.in_c[name])
        if isinstance(given, Variable):
            self.function.parameters.append((given.name, given.type))
        if name in self.changing and not isinstance(given, Table):
            first = whole(given) if isinstance(given, Known) else given
            own = self.declared(self.fresh(f"{self.in_c[name]}_now"), first.type)
            self.changed(own, first)
            given = own
        self.environment[name] = given

    def declared(self, name: str, kind: Type) -> Variable:
        """A local that changes."""
        self.function.locals[name] = kind
        return Variable(kind, name, mutable=True)

    def changed(self, local: Variable, value: Expression) -> None:
        """A new value for a local that changes."""
        self.certain.add(local.name)
        self.block.append(Assign(local.name, value))

    def let(self, name: str, value: Value) -> Value:
        """The value under a name; what is known while translating needs none in C."""
        if not isinstance(value, Expression):
            return value
        self.block.append(Let(name, value))
        return Variable(value.type, name)

    def lasting(self, value: Expression) -> Expression:
        """A record that has an address: a value just computed gets a name."""
        if isinstance(value, (Variable, Member)):
            return value
        name = value.function.origin.__name__ if isinstance(value, Call) else "record"
        named = self.let(self.fresh(identifier(name)), value)
        assert isinstance(named, Expression)
        return named

    def fresh(self, name: str) -> str:
        """A name that the function does not use."""
        found = self.local_name(name, self.taken)
        self.taken.add(found)
        return found

    def error(self, problem: str, node: ast.AST, way_out: str = WAY_OUT) -> TranslationError:
        where = place(self.origin, getattr(node, "lineno", 0))
        return TranslationError(f"{where}, {self.origin.__qualname__}: {problem}; {way_out}")


def whole(value: Known) -> Whole:
    """A whole number or truth value in C.

    Raises:
        TranslationError: it is out of C's range.
    """
    if isinstance(value.value, bool):
        return Whole(BOOL, value.value)
    if abs(value.value) >= LARGEST_WHOLE:
        raise TranslationError(f"the whole number {value.value} is beyond 2^53")
    return Whole(INT, value.value)


def parsed(origin: FunctionType) -> ast.FunctionDef:
    """A function's syntax tree, with the lines of its file."""
    try:
        lines, first = inspect.getsourcelines(origin)
    except (OSError, TypeError):
        raise TranslationError(f"{place(origin)}: the text of {origin.__qualname__} is not there") from None
    tree = ast.parse(textwrap.dedent("".join(lines)))
    ast.increment_lineno(tree, max(first, 1) - 1)
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise TranslationError(f"{place(origin)}: not a function with a def; {WAY_OUT}")
    return definition
