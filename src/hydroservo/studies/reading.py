"""Values of a study's file, each checked where it stands."""

from collections.abc import Sequence
from numbers import Real
from typing import Any

from hydroservo.errors import ParameterError
from hydroservo.nearest import one_of
from hydroservo.scenario.tables import Entry, Table
from hydroservo.validation import whole_number

LARGEST = 1e300
FILE = "file"  # key of a recorded signal


def known_keys(table: Table, allowed: Sequence[str]) -> None:
    """Refuse a key that a table does not have."""
    for name in table.names():
        if name not in allowed:
            raise table.entry(name).unknown(name, allowed)


def text(table: Table, name: str, default: str | None = None) -> str:
    """A text that is not empty."""
    if not table.has(name):
        if default is None:
            raise table.error(f"needs {name}")
        return default
    entry = table.entry(name)
    if not isinstance(entry.value, str) or not entry.value.strip():
        raise entry.error("must be a text")
    return entry.value


def texts(
    table: Table, name: str, allowed: Sequence[str] | None = None, default: Sequence[str] = ()
) -> list[str]:
    """Different texts, of those that are allowed; any if None."""
    if not table.has(name):
        return list(default)
    entry = table.entry(name)
    found = entry.value
    if not isinstance(found, list) or not found or not all(isinstance(one, str) for one in found):
        raise entry.error("must be a list of texts")
    if len(set(found)) < len(found):
        raise entry.error("names one twice")
    for one in found:
        if allowed is not None and one not in allowed:
            raise entry.error(f"names {one!r}; it {one_of(one, allowed)}")
    return found


def whole(table: Table, name: str, low: int, high: int, default: int) -> int:
    """A whole number between two others."""
    if not table.has(name):
        return default
    entry = table.entry(name)
    try:
        return whole_number(name, entry.value, low, high)
    except ParameterError as error:
        raise entry.error(error.allowed) from None


def numbers(table: Table, name: str, low: float, high: float, default: Sequence[float]) -> list[float]:
    """Different numbers between two others, the smallest first."""
    if not table.has(name):
        return list(default)
    entry = table.entry(name)
    found = entry.value
    real = isinstance(found, list) and all(map(is_real, found))
    if not real or not found or not all(low <= one <= high for one in found) or sorted(set(found)) != found:
        raise entry.error(f"must be a list of numbers from {low:g} to {high:g}, the smallest first")
    return [float(one) for one in found]


def is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def finite(entry: Entry) -> float:
    """A finite number."""
    value = entry.value
    if not is_real(value) or not -LARGEST <= value <= LARGEST:
        raise entry.error(f"must be a number from {-LARGEST:g} to {LARGEST:g}")
    return float(value)


def changes_in(table: Table, name: str) -> dict[str, Any]:
    """Changes to a scenario by dotted path, as they stand in nested tables or under dotted keys."""
    return {path: entry_value(entry) for path, entry in table.table(name).entries()}


def entry_value(entry: Entry) -> Any:
    """A value as any folder may have it: the path of a recording from here, not from its own file."""
    is_file = entry.key.rpartition(".")[2] == FILE and isinstance(entry.value, str)
    return str(entry.origin.folder / entry.value) if is_file else entry.value


def ranges_in(table: Table, name: str) -> dict[str, Entry]:
    """What varies by path, each as an entry that says where it stands."""
    return dict(table.table(name).entries())
