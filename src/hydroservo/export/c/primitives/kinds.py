"""What the functions on whole states ask of the types they are made for."""

from collections.abc import Iterator

from hydroservo.language.names import identifier
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import Known, Record, Type


def known_of(kind: Type) -> int:
    """A whole number that is part of the code."""
    if not (isinstance(kind, Known) and isinstance(kind.value, int)):
        raise TranslationError("the kind of a random number is part of the code, not a signal")
    return kind.value


def leaf_places(record: Record, place: str = "") -> Iterator[str]:
    """The place of each number of a record, whether it is needed or not."""
    for name, kind in record.fields.items():
        if isinstance(kind, Record):
            yield from leaf_places(kind, f"{place}{identifier(name)}.")
        else:
            yield place + identifier(name)
