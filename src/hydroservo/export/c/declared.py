"""What the numbers of a record were declared as in Python."""

from collections.abc import Mapping
from typing import Any

from hydroservo.block import in_signal
from hydroservo.export.translate.terms import Record
from hydroservo.field import Field, declared_fields

__all__ = ["declared_in"]


def declared_in(record: Record, signal: Field) -> Mapping[str, Field]:
    """The declarations of a record's numbers by name.

    Args:
        record: the record.
        signal: what the loop controls, in whose unit some are; a law that says its own has that.
    """
    if record.cls is None:
        return {}
    own = record.fields.get("controls")
    cls: Any = own.cls if isinstance(own, Record) else None
    known = cls().declared() if cls is not None else signal
    return {name: in_signal(field, known) for name, field in declared_fields(record.cls).items()}
