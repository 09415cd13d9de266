"""The names of a function that is being translated, and where its statements go."""

import ast
from collections.abc import Callable, Set
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from hydroservo.core.errors import LoopError
from hydroservo.language.bindings import Binding, bindings_of
from hydroservo.language.names import identifier
from hydroservo.language.ranges import LARGEST, LARGEST_REAL, Ranges
from hydroservo.language.source import DoubtError, definition
from hydroservo.language.terms import (
    BOOL,
    INT,
    Assign,
    Bound,
    Call,
    ConstantArray,
    Expression,
    Function,
    HostObject,
    Known,
    Let,
    Member,
    Several,
    Statement,
    Type,
    Variable,
    Whole,
)

Value = Expression | Known | ConstantArray | HostObject | Bound | Several

WAY_OUT = "methods call only ops, each other and nested blocks"


class TranslationError(LoopError):
    """A text that is not in the language; the message names file, line and the way out.

    Attributes:
        problem: the message without its place.
        places: the files and lines that it is about, from the inside out.
    """

    def __init__(self, problem: str, where: str = "") -> None:
        self.problem = problem
        self.places: list[tuple[str, int]] = []
        super().__init__(f"{where}: {problem}" if where else problem)


def source_place(function: Any, line: int = 0) -> str:
    """The file of a Python function and a line in it."""
    code = function.__code__
    return f"{code.co_filename}, line {line or code.co_firstlineno}"


class Limit(NamedTuple):
    """A whole number, how small and how large it may become, and where it stands."""

    value: Expression
    least: int
    most: int
    node: ast.AST


class Scope:
    """One Python function that is being translated.

    Making one raises :class:`TranslationError` where the function's text is not there.

    Args:
        origin: the Python function.
        name: of its equal in C.
        owner: the class whose method it is.
        local_name: finds a free name for a local, from a wish and those that the function has given.
    """

    def __init__(
        self, origin: FunctionType, name: str, owner: type | None, local_name: Callable[[str, Set[str]], str]
    ) -> None:
        self.origin = origin  # the Python function
        self.tree = parse_function(origin)  # its syntax tree, with the lines of its file
        # its terms, as far as it is translated
        self.function = Function(name, [], origin=origin, owner=owner)
        self.bindings = bindings_of(self.tree)  # which variable each name is, wherever it stands
        self.local_name = local_name
        self.taken: set[str] = set()
        self.in_c: dict[Binding, str] = {}
        for one in self.bindings.all():
            self.in_c[one] = self.named_in_c(one)
        self.environment: dict[Binding, Value] = {}  # what each variable stands for
        self.certain: set[str] = set()  # the changing locals that have a value by now
        self.block: list[Statement] = self.function.body  # where statements go
        self.whole: list[Limit] = []  # the whole numbers that are computed, and how large each may become
        self.lets: set[str] = set()
        self.line = origin.__code__.co_firstlineno  # what is translated now
        cells = [cell.cell_contents for cell in origin.__closure__ or ()]
        # what it takes from the functions around it, by name
        self.outside: dict[str, Any] = dict(zip(origin.__code__.co_freevars, cells, strict=True))
        # it is one of hydroservo's, whose whole numbers are known to be small
        self.house = f"{origin.__module__}".startswith("hydroservo.")
        # it is one of the engine's, which may call functions and use memory
        self.engine = f"{origin.__module__}".startswith("hydroservo.engine.")

    @property
    def place(self) -> tuple[str, int]:
        """The file, its path absolute, and the line of what is translated now."""
        return str(Path(self.origin.__code__.co_filename).absolute()), self.line

    def named_in_c(self, binding: Binding) -> str:
        """A variable's name: its own, with a number behind it where another one has that."""
        if binding.name != "_":
            return self.fresh(identifier(binding.name))
        return self.fresh("i" if binding.counter else "value" if binding.read else "unread")

    def parameter(self, name: str, kind: Type) -> None:
        """A parameter; one that the function assigns to gets a local of its own."""
        binding = self.bindings.arguments[name]
        own_name = self.in_c[binding]
        given = known_value(kind) if isinstance(kind, (Known, ConstantArray)) else Variable(kind, own_name)
        if isinstance(given, Variable):
            self.function.parameters.append((given.name, given.type))
        if binding.changing and isinstance(given, Known | Variable) and given != Known(None):
            try:
                first = runtime_whole(given) if isinstance(given, Known) else given
            except TranslationError as error:
                raise self.error(f"{name}: {error}", self.tree, "use floats") from None
            own = self.declare(self.fresh(f"{own_name}_now"), first.type)
            self.assign(own, first)
            given = own
        self.environment[binding] = given

    def declare(self, name: str, kind: Type) -> Variable:
        """A local that changes."""
        self.function.locals[name] = kind
        return Variable(kind, name, mutable=True)

    def assign(self, local: Variable, value: Expression) -> None:
        """A new value for a local that changes."""
        self.certain.add(local.name)
        if not (isinstance(value, Variable) and value.name == local.name):
            self.block.append(Assign(local.name, value))

    def let(self, name: str, value: Value) -> Value:
        """The value under a name, a new one each time; what is known while translating needs none."""
        if isinstance(value, Several):
            items = [
                self.let(self.fresh(f"{name}_{part}"), item)
                for part, item in zip(value.names, value.items, strict=True)
            ]
            return Several(tuple(items), value.names, value.once)
        if not isinstance(value, Expression):
            return value
        name = self.fresh(name) if name in self.lets else name
        self.lets.add(name)
        self.block.append(Let(name, value))
        return Variable(value.type, name)

    def with_address(self, value: Expression) -> Expression:
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

    def limit(self, value: Expression, most: int, node: ast.AST, least: int | None = None) -> None:
        """Asks that a whole number stays within [-most, most], or [least, most]."""
        if value.type == INT and not self.house:
            self.whole.append(Limit(value, -most if least is None else least, most, node))

    def check_whole(self) -> None:
        """Refuse whole numbers that may leave their limits, once the function is translated."""
        if not self.whole:
            return
        ranges = Ranges(self.function)
        for value, least, most, node in self.whole:
            low, high = ranges.interval(value)
            if low >= least and high <= most:
                continue
            text = ast.unparse(node).partition("\n")[0]
            bits = "64 bits" if most == LARGEST else f"{least} to {most}"
            raise self.error(f"{text!r}: a whole number that may outgrow {bits}", node, "use floats")

    def error(self, problem: str, node: ast.AST, way_out: str = WAY_OUT) -> TranslationError:
        self.line = getattr(node, "lineno", self.line)
        where = f"{source_place(self.origin, self.line)}, {self.origin.__qualname__}"
        return TranslationError(f"{problem}; {way_out}", where)


def known_value(kind: Known | ConstantArray) -> Value:
    """What a parameter of a type that is known stands for."""
    if isinstance(kind, Known) and not isinstance(kind.value, int | None):
        return HostObject(kind.value)
    return kind


def runtime_whole(value: Known) -> Whole:
    """A whole number or truth value at run time; nothing stays nothing."""
    if value.value is None:
        return Whole(value, 0)
    if isinstance(value.value, bool):
        return Whole(BOOL, value.value)
    if abs(value.value) > LARGEST_REAL:
        raise TranslationError(f"the whole number {value.value} is beyond 2^53")
    return Whole(INT, value.value)


def parse_function(origin: FunctionType) -> ast.FunctionDef:
    """A function's syntax tree, with the lines of its file."""
    try:
        return definition(origin)
    except DoubtError as doubt:
        where = f"{source_place(origin)}, {origin.__qualname__}"
        raise TranslationError(f"{doubt}; write a plain method of the block", where) from None
