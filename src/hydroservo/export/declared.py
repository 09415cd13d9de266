"""What the numbers of a record were declared as in Python."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from hydroservo.core.block import Block, in_signal, nested_signal, nested_state
from hydroservo.core.field import Field, declared_fields
from hydroservo.language.terms import Record, Type

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
