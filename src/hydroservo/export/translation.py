"""A unit of a loop as functions and records, before it is written in a language."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple, TypeVar

from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.export.declared import declarations_by_name, in_arguments, in_parameters, in_state
from hydroservo.export.unit import Part
from hydroservo.language.liveness import Liveness
from hydroservo.language.terms import ConstantArray, Function, Record, Type

Argument = TypeVar("Argument")


class Translation(NamedTuple):
    """A translated unit."""

    block: Block  # its parameters
    parameters: Record  # their record
    init: Function  # makes the first state
    step: Function  # makes the next one
    arguments: tuple[tuple[str, Record], ...]  # name and record of what ``step`` is given besides the state
    part: Part  # of the loop
    records: tuple[Record, ...]  # all that its functions know
    tables: tuple[ConstantArray, ...]  # all that its functions know
    signal: Field  # what the loop controls

    @property
    def start(self) -> Block:
        """The first state."""
        return self.block.init()

    @property
    def stepped(self) -> Block:
        """The block whose state it is: a unit's, but of a controller's the controller's own."""
        return self.block.controller if self.part is Part.CONTROLLER else self.block

    def signals(self) -> Mapping[Record, Sequence[Field | None]]:
        """What the numbers of each record are of that an argument, the parameters or the state have."""
        places = chain(
            *(in_arguments(record, self.signal) for _, record in self.arguments),
            in_parameters(self.block, self.parameters, self.signal),
            in_state(self.stepped, self.start, self.init.returns, self.signal),
        )
        found: dict[Record, dict[Field | None, None]] = {}
        for record, signal in places:
            found.setdefault(record, {})[signal] = None
        return {record: tuple(signals) for record, signals in found.items()}


def ordered_records(records: Sequence[Any], needed: Liveness) -> list[Record]:
    """Records of which something is kept, each after those in it."""
    found: dict[Record, None] = {}

    def add(record: Any) -> None:
        if isinstance(record, Record) and record not in found and needed.kept(record):
            for name, kind in record.fields.items():
                if needed.has(record, name):
                    add(kind)
            found[record] = None

    for record in records:
        add(record)
    return list(found)


class UnitWriter:
    """What the writers of all languages know of a unit.

    Args:
        prefix: of the names that they write.
        real: the type of numbers.
        needed: what is needed; the rest is left out.
        signals: the controlled signals in whose units the numbers of each record are; of others, all of them.
    """

    def __init__(
        self, prefix: str, real: str, needed: Liveness, signals: Mapping[Record, Sequence[Field | None]]
    ) -> None:
        self.prefix, self.real, self.needed, self.signals = prefix, real, needed, signals
        self.every = tuple(dict.fromkeys(signal for of_record in signals.values() for signal in of_record))

    def kept(self, record: Record) -> Iterator[tuple[str, Type]]:
        """The fields of a record that are written."""
        return ((name, kind) for name, kind in record.fields.items() if self.needed.has(record, name))

    def declared(self, record: Record) -> Iterator[tuple[str, Type, Field]]:
        """Name, type and declaration of each of these."""
        fields = declarations_by_name(record, self.signals.get(record, self.every))
        return ((name, kind, fields.get(name, Field("", ""))) for name, kind in self.kept(record))

    def arguments_of(self, function: Function, arguments: Sequence[Argument]) -> list[Argument]:
        """Those of a call's arguments that a function takes."""
        names = {name for name, _ in self.needed.takes(function)}
        pairs = zip(function.parameters, arguments, strict=True)
        return [argument for (name, _), argument in pairs if name in names]


def about_record(record: Record) -> str:
    """The name and the first sentence of a record's class; empty for one of several values."""
    return f"{record.cls.__name__}: {first_paragraph(record.cls)}" if record.cls else ""


def first_paragraph(documented: Any) -> str:
    """The first paragraph of a docstring."""
    return (inspect.getdoc(documented) or "").partition("\n\n")[0] if documented else ""
