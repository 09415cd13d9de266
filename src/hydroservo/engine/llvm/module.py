"""The text of a module: functions, the types that they use and the tables that they read."""

import struct
from collections.abc import Callable
from typing import Any

from hydroservo.language.terms import (
    BOOL,
    INT,
    NOTHING,
    REAL,
    Array,
    Call,
    Expression,
    Function,
    Known,
    Memory,
    Record,
    Require,
    Statement,
    Table,
    Type,
)

NUMBERS = {REAL: "double", INT: "i64", BOOL: "i1"}


class Module:
    """The text of functions, of the types that they use and of the tables that they read.

    Args:
        write: gives the text of a function.
    """

    def __init__(self, write: Callable[["Module", Function], str]) -> None:
        self.write = write
        self.functions: dict[Function, str] = {}
        self.records: dict[Record, str] = {}
        self.types: list[str] = []
        self.tables: dict[Table, str] = {}
        self.declared: dict[str, str] = {}
        self.few: list[bool] = []  # of each loop, whether it has few turns
        self.failing: dict[Function, bool] = {}

    def type(self, kind: Type) -> str:
        """LLVM's name of a type."""
        if isinstance(kind, Record):
            if kind not in self.records:
                inner = ", ".join(self.type(part) for part in fields_of(kind).values())
                self.records[kind] = f"%r{len(self.records)}"
                self.types.append(f"{self.records[kind]} = type {{{inner}}}")
            return self.records[kind]
        if isinstance(kind, Array):
            return f"{{{', '.join(['ptr', *['i64'] * len(kind.lengths)])}}}"
        if kind == NOTHING:
            return "void"
        return "ptr" if isinstance(kind, Memory) else NUMBERS[kind]  # type: ignore[index]

    def table(self, table: Table) -> str:
        """The name of a table that is written into the text."""
        if table not in self.tables:
            self.tables[table] = f"@t{len(self.tables)}"
        return self.tables[table]

    def name(self, function: Function) -> str:
        """The name of a function, whose text is written if it is not there yet."""
        if function not in self.functions:
            self.functions[function] = ""
            self.functions[function] = self.write(self, function)
        return f"@f.{function.name}"

    def fails(self, function: Function) -> bool:
        """Whether a function may raise an exception."""
        if function not in self.failing:
            self.failing[function] = any(map(self.may_fail, function.body))
        return self.failing[function]

    def may_fail(self, one: Any) -> bool:
        """Whether a statement or an expression may raise an exception."""
        if isinstance(one, Require):
            return True
        if isinstance(one, Call) and self.fails(one.function):
            return True
        return any(map(self.may_fail, parts_of(one)))

    def declare(self, name: str, returned: str, *taken: str) -> str:
        """The name of a function of LLVM or of the C library."""
        self.declared[name] = f"declare {returned} @{name}({', '.join(taken)})"
        return f"@{name}"

    def text(self, entry: str) -> str:
        """All of it, with the function that is called from outside."""
        tables = [
            f"{name} = private unnamed_addr constant [{table.array.size} x double] "
            f"[{', '.join(f'double {literal(x)}' for x in table.array.ravel().tolist())}]"
            for table, name in self.tables.items()
        ]
        unrolled = len(self.few) + 1
        nodes = [f"!{i} = distinct !{{!{i}, !{unrolled if few else 0}}}" for i, few in enumerate(self.few, 1)]
        nodes.append(f'!{unrolled} = !{{!"llvm.loop.unroll.full"}}')
        parts = [*self.types, *tables, *self.declared.values(), *self.functions.values(), entry, *nodes]
        return "\n".join(parts) + "\n"


def fields_of(record: Record) -> dict[str, Type]:
    """The fields of a record that it has at run time."""
    return {name: kind for name, kind in record.fields.items() if not isinstance(kind, Known | Table)}


def literal(number: float) -> str:
    """A float to its last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}"


def parts_of(one: Any) -> list[Any]:
    """The statements and expressions that a statement or an expression is made of."""
    parts: list[Any] = []
    for part in vars(one).values():
        each = (
            part.values() if isinstance(part, dict) else part if isinstance(part, list | tuple) else (part,)
        )
        parts += [value for value in each if isinstance(value, Expression | Statement)]
    return parts
