"""Writes records as structures of Structured Text, and knows what everything is called."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from hydroservo.core.field import Field
from hydroservo.export.single import SINGLE
from hydroservo.export.st.names import literal_of, parts_of, unused_name
from hydroservo.export.st.pou import Declaration, Pou, Structure, remark
from hydroservo.export.st.primitives import TEXTS, text_function, with_callees
from hydroservo.export.translation import UnitWriter, about_record
from hydroservo.language import terms
from hydroservo.language.liveness import Liveness
from hydroservo.language.names import identifier
from hydroservo.language.scope import TranslationError

ATOM, UNARY = 7, 6  # how strongly operators bind

VARIABLES = "active_parameters command demand measurement own_parameters parameters reset running state"
OWN = frozenset(VARIABLES.split())  # in every function block
RESERVED = ("defaults", "expected", "differs")  # functions of the block and of its replay


class STWriter(UnitWriter):
    """What everything in Structured Text is called, and the text of records; numbers are LREAL or REAL."""

    def __init__(
        self, prefix: str, real: str, needed: Liveness, signals: Mapping[terms.Record, Sequence[Field | None]]
    ) -> None:
        super().__init__(prefix, real, needed, signals)
        own = (block_name(prefix), *(f"{prefix}_{name}" for name in (*TEXTS, *RESERVED)))
        self.taken = {name.casefold() for name in own}
        self.types: dict[terms.Record, str] = {}
        self.functions: dict[terms.Function, str] = {}
        self.members: dict[terms.Record, dict[str, str]] = {}
        self.primitives: list[str] = []

    # records

    def name_all(self, records: Iterable[terms.Record]) -> None:
        """Gives types and functions their names, which those within them shall not have."""
        for record in records:
            self.type(record)
        for function in self.needed.reached:
            self.function_name(function)

    def global_name(self, name: str) -> str:
        """A name that nothing has, nor a variable of the function block."""
        found = unused_name(f"{self.prefix}_{name}", {*self.taken, *OWN})
        self.taken.add(found.casefold())
        return found

    def type(self, kind: terms.Type) -> str:
        """A type's name."""
        if not isinstance(kind, terms.Record):
            return {terms.REAL: self.real, terms.INT: "LINT", terms.BOOL: "BOOL"}[kind]  # type: ignore[index]
        if kind not in self.types:
            self.types[kind] = self.global_name(kind.name)
        return self.types[kind]

    def member(self, record: terms.Record, name: str) -> str:
        """The name of a record's field."""
        if record not in self.members:
            taken = set(self.taken)
            self.members[record] = {one: unused_name(one, taken) for one in record.fields}
        return self.members[record][name]

    def places(self, record: terms.Record, in_c: str = "", place: str = "") -> Iterator[tuple[str, str]]:
        """The place in C of each number of a record, and its place here."""
        for name, kind in self.kept(record):
            both = f"{in_c}{identifier(name)}", f"{place}{self.member(record, name)}"
            if isinstance(kind, terms.Record):
                yield from self.places(kind, f"{both[0]}.", f"{both[1]}.")
            else:
                yield both

    def record(self, record: terms.Record) -> Structure:
        """The definition of a record's type."""
        fields = [
            Declaration(self.member(record, name), self.type(kind), remark(field.unit, field.meaning))
            for name, kind, field in self.declared(record)
        ]
        return Structure(self.type(record), about_record(record), fields)

    # functions

    def function_name(self, function: terms.Function) -> str:
        if not function.body:
            return self.primitive(function.name)
        if function not in self.functions:
            self.functions[function] = self.global_name(function.name)
        return self.functions[function]

    def primitive(self, name: str) -> str:
        """The name of a primitive, which is written from now on."""
        if name not in TEXTS:
            raise TranslationError(f"{name.removeprefix('ops_')}: Structured Text has no such function")
        self.primitives.append(name)
        return f"{self.prefix}_{name}"

    def text_functions(self) -> list[Pou]:
        """All primitives that are called so far."""
        return [text_function(name, self.prefix, self.real) for name in with_callees(self.primitives)]

    # numbers

    def number(self, value: float) -> tuple[str, int]:
        """A literal that gives the very number, or a call that does."""
        if math.isnan(value):
            return f"{self.primitive('nan')}(FALSE)", ATOM
        if text := literal_of(value, self.real):
            return text, UNARY if text[0] == "-" else ATOM
        return f"{self.primitive('number')}({', '.join(parts_of(value, self.real))})", ATOM

    def constant(self, value: terms.NamedNumber | terms.Computed) -> float:
        """The number of a constant in this precision."""
        if isinstance(value, terms.NamedNumber) and self.real == "REAL":
            return SINGLE.get((value.module, value.name), value.value)
        return value.value


def block_name(prefix: str) -> str:
    """The name of a unit's function block."""
    return f"fb_{prefix}"
