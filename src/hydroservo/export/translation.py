"""A unit of a loop as functions and records, before it is written in a language."""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.field import Field
from hydroservo.export.declared import in_arguments, in_parameters, in_state
from hydroservo.export.unit import Part
from hydroservo.language.liveness import Liveness
from hydroservo.language.terms import ConstantArray, Function, Record


class Translation(NamedTuple):
    """A translated unit.

    Attributes:
        block: its parameters.
        parameters: their record.
        init: makes the first state.
        step: makes the next one.
        arguments: name and record of what ``step`` is given besides the state.
        part: of the loop.
        records: all that its functions know.
        tables: all that its functions know.
        signal: what the loop controls.
    """

    block: Block
    parameters: Record
    init: Function
    step: Function
    arguments: tuple[tuple[str, Record], ...]
    part: Part
    records: tuple[Record, ...]
    tables: tuple[ConstantArray, ...]
    signal: Field

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
