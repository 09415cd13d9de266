"""Translates the methods of blocks from Python to terms, by their syntax trees.

A method is translated once for each combination of types that it is called with, with the same names,
operations and order of operations. What is known while translating (switches, numbers of bits) becomes part
of the code.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence, Set
from typing import Any

import numpy as np

from hydroservo.core.block import is_block
from hydroservo.language.body import Body
from hydroservo.language.names import free_name, identifier, snake
from hydroservo.language.scope import TranslationError, source_place
from hydroservo.language.source import DoubtError, changed_class, own_method
from hydroservo.language.terms import REAL, ConstantArray, Function, Known, Record, Translator, Type

DEEPEST = 60  # calls of a method by itself, each for another number that is known while translating


class Program:
    """All functions, records and tables of one export.

    Args:
        written: what makes the function for a Python function that is not translated from its text, such as
            ``ops.sqrt``, by that function; each takes the translator and the types of the arguments.
        prefix: of public names and of types, which functions must not be given.
    """

    def __init__(
        self, written: Mapping[Any, Callable[[Translator, Sequence[Type]], Function]], prefix: str
    ) -> None:
        self.written = written
        self.functions: dict[Any, Function] = {}
        self.records: dict[Any, Record] = {}
        self.tables: dict[int, ConstantArray] = {}
        self.names = {"parameters", "state", "init", "step", "defaults", "fixed"}
        self.called: set[str] = set()
        self.locals: set[str] = set()
        self.public = f"{prefix}_"
        self.active: list[Any] = []

    def record(self, cls: type | None, fields: Mapping[str, Type], name: str) -> Record:
        """The one record of a class with fields of these types."""
        key = (cls or name, tuple(fields.items()))
        if key not in self.records:
            if cls is not None and (changed := changed_class(cls)):
                raise TranslationError(f"{name}: {cls.__qualname__} has {changed}; write a plain NamedTuple")
            if len({identifier(field) for field in fields}) < len(fields):
                raise TranslationError(f"{name}: two of the fields {', '.join(fields)} have one name in C")
            self.records[key] = Record(cls, self.unique(name), dict(fields))
        return self.records[key]

    def type_of(self, value: Any, name: str = "") -> Type:
        """The type of a parameter or state: a block is a record, a float real, all else part of the code."""
        if is_block(value):
            fields = {key: self.type_of(getattr(value, key), f"{name}_{key}") for key in value._fields}
            return self.record(type(value), fields, snake(type(value).__name__))
        if isinstance(value, np.ndarray):
            if id(value) not in self.tables:
                self.tables[id(value)] = ConstantArray(self.unique(f"table{name}"), value)
            return self.tables[id(value)]
        if isinstance(value, float):
            return REAL
        return Known(int(value) if isinstance(value, np.integer) else value)

    def function(self, origin: Any, arguments: Sequence[Type], owner: type | None = None) -> Function:
        """The C function of a Python function for arguments of these types."""
        key = (origin, tuple(arguments))
        if key not in self.functions:
            if origin in self.written:
                made = self.written[origin](self, arguments)
                made.origin = origin
            else:
                again = sum(one is origin for one, _ in self.active)
                if key in self.active or again > DEEPEST:
                    raise TranslationError(f"{source_place(origin)}: {origin.__qualname__} calls itself")
                self.active.append(key)
                made = Body(self, origin, arguments, owner).translated()
                self.active.pop()
            self.functions[key] = made
        return self.functions[key]

    def method(self, record: Record, name: str, arguments: Sequence[Type]) -> Function:
        """The C function of a record's method."""
        assert record.cls is not None
        try:
            found = own_method(record.cls, name)
        except DoubtError as doubt:
            file = inspect.getsourcefile(record.cls)
            problem = f"{file}: {doubt}; write it as a plain method of the class"
            raise TranslationError(problem) from None
        return self.function(found, [record, *arguments], record.cls)

    def function_name(self, name: str) -> str:
        """A name for a function that no other one has, nor a local, a public name or a type."""
        wish = f"own_{name}" if name.startswith(self.public) else name
        found = free_name(wish, lambda one: one in self.called or one in self.locals)
        self.called.add(found)
        return found

    def local_name(self, name: str, taken: Set[str]) -> str:
        """A name for a local that no function or type has, nor another local of its function."""
        wish = f"own_{name}" if name.startswith((self.public, self.public.upper())) else name
        found = free_name(wish, lambda one: one in taken or one in self.called)
        self.locals.add(found)
        return found

    def unique(self, name: str) -> str:
        """A name for a record or table that no other one has."""
        found = free_name(name, self.names.__contains__)
        self.names.add(found)
        return found


def check_law(program: Program, law: Any, arguments: Sequence[Type]) -> None:
    """Refuse a law whose step gives something else than its state."""
    state = program.method(law, "init", []).returns
    step = program.method(law, "step", [state, *arguments, REAL])
    if not isinstance(state, Record) or step.returns is not state:
        where = f"{source_place(step.origin)}, {step.origin.__qualname__}"
        raise TranslationError(f"{where}: it must return the record that init returns, with floats in it")
