"""Translates the methods of blocks from Python to C, by their syntax trees.

A method is translated once for each combination of types that it is called with, as compiled Python is:
a function in C for a method in Python, with the same names, operations and order of operations. What is
known while translating (switches, numbers of bits, arrays of records) becomes part of the code.
"""

from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any

import numpy as np

from hydroservo.block import is_block
from hydroservo.export.body import Body
from hydroservo.export.names import snake
from hydroservo.export.scope import TranslationError, place
from hydroservo.export.terms import REAL, Function, Known, Record, Table, Type

__all__ = ["Translator"]


class Translator:
    """All functions, records and tables of one export.

    Args:
        written: what makes the function for a Python function that is not translated from its text, such as
            ``ops.sqrt``, by that function; each takes the translator and the types of the arguments.
    """

    def __init__(self, written: Mapping[Any, Callable[["Translator", Sequence[Type]], Function]]) -> None:
        self.written = written
        self.functions: dict[Any, Function] = {}
        self.records: dict[Any, Record] = {}
        self.tables: dict[int, Table] = {}
        self.names: set[str] = set()
        self.active: list[FunctionType] = []

    def record(self, cls: type | None, fields: Mapping[str, Type], name: str) -> Record:
        """The one record of a class with fields of these types."""
        key = (cls or name, tuple(fields.items()))
        if key not in self.records:
            self.records[key] = Record(cls, self.unique(name), dict(fields))
        return self.records[key]

    def type_of(self, value: Any, name: str = "") -> Type:
        """The type of a parameter or state: a block is a record, a float real, all else part of the code."""
        if is_block(value):
            fields = {key: self.type_of(getattr(value, key), f"{name}_{key}") for key in value._fields}
            return self.record(type(value), fields, snake(type(value).__name__))
        if isinstance(value, np.ndarray):
            if id(value) not in self.tables:
                self.tables[id(value)] = Table(self.unique(f"table{name}"), value)
            return self.tables[id(value)]
        return REAL if isinstance(value, float) else Known(value)

    def function(self, origin: Any, arguments: Sequence[Type], owner: type | None = None) -> Function:
        """The C function of a Python function for arguments of these types."""
        key = (origin, tuple(arguments))
        if key not in self.functions:
            if origin in self.written:
                made = self.written[origin](self, arguments)
                made.origin = origin
            else:
                if origin in self.active:
                    raise TranslationError(f"{place(origin)}: {origin.__qualname__} calls itself")
                self.active.append(origin)
                made = Body(self, origin, arguments, owner).translated()
                self.active.pop()
            self.functions[key] = made
        return self.functions[key]

    def method(self, record: Record, name: str, arguments: Sequence[Type]) -> Function:
        """The C function of a record's method."""
        return self.function(vars(record.cls)[name], [record, *arguments], record.cls)

    def unique(self, name: str) -> str:
        """A name that nothing else has."""
        found, number = name, 2
        while found in self.names:
            found, number = f"{name}_{number}", number + 1
        self.names.add(found)
        return found
