"""A unit of a loop as functions and records, before it is written in a language."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, NamedTuple, TypeVar

from hydroservo.core.block import Block, in_signal, nested_signal, nested_state
from hydroservo.core.field import Field, declared_fields
from hydroservo.export.unit import Part
from hydroservo.language.liveness import Liveness
from hydroservo.language.terms import ConstantArray, Function, Record, Type

Signals = Iterator[tuple[Record, Field | None]]  # what the numbers of a record are of at one of its places


def declarations_by_name(record: Record, signals: Sequence[Field | None]) -> Mapping[str, Field]:
    """The declarations of a record's numbers by name."""
    if record.cls is None:
        return {}
    declared = {name: of_all(field, signals) for name, field in declared_fields(record.cls).items()}
    return declared | {name: replace(declared[name], unit=unit) for name, unit in record.units.items()}


def of_all(field: Field, signals: Sequence[Field | None]) -> Field:
    """A declaration with the units and the names of all that a number may be of."""
    found = list(dict.fromkeys(in_signal(field, signal) for signal in signals))
    if len(found) == 1:
        return found[0]
    units = dict.fromkeys(one.unit for one in found)
    names = Field("", " or ".join(signal.meaning for signal in signals if signal is not None))
    return replace(field, unit=" or ".join(units), meaning=field.of(names).meaning)


def in_parameters(block: Block, kind: Type, signal: Field | None) -> Signals:
    """What the records of a block's parameters are of, place by place.

    Args:
        block: the parameters.
        kind: their record; any other type has none in it.
        signal: what those of the block itself are of.
    """
    if isinstance(kind, Record):
        yield kind, signal
        for name, inner in kind.fields.items():
            yield from in_parameters(getattr(block, name), inner, nested_signal(block, name, signal))


def in_state(block: Block | None, state: Block, kind: Type, signal: Field | None) -> Signals:
    """What the records of a block's state are of, place by place.

    Args:
        block: the block; None where the state is that of no block.
        state: its state.
        kind: the state's record; any other type has none in it.
        signal: what the numbers of the block itself are of.
    """
    if isinstance(kind, Record):
        yield kind, signal
        for name, inner in kind.fields.items():
            own, below = nested_state(block, state, name, signal)
            yield from in_state(own, getattr(state, name), inner, below)


def in_arguments(kind: Type, signal: Field | None) -> Signals:
    """What the records of an argument are of: the loop's signal."""
    if isinstance(kind, Record):
        yield kind, signal
        for inner in kind.fields.values():
            yield from in_arguments(inner, signal)


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
