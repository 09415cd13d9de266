"""In what compared scenarios differ besides their controllers, as lines for a terminal."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.block import field_at
from hydroservo.formatting import common_unit, yes_or_no

if TYPE_CHECKING:
    from hydroservo.loop import Loop

MOST_LINES = 8  # of single values; more are counted by table


def unequal_lines(differences: Mapping[str, tuple[Any, ...]], loops: Sequence["Loop"]) -> list[str]:
    """What ``conditions.differences`` found, with the value in each run; nothing if that is empty."""
    if not differences:
        return []
    if len(differences) <= MOST_LINES:
        lines = [
            f"  {path}: {', '.join(value_texts(path, values, loops))}" for path, values in differences.items()
        ]
    else:
        counts = Counter(path.partition(".")[0] for path in differences)
        tables = ", ".join(f"{name} ({count})" for name, count in counts.items())
        lines = [f"  {len(differences)} values in the tables {tables}; --json lists them"]
    return ["No run is marked best, for they differ in more than the controller:", *lines]


def value_texts(path: str, values: Sequence[Any], loops: Sequence["Loop"]) -> list[str]:
    """What each run has at a path, numbers in a common unit and with as many digits as tell them apart."""
    numbers = [value for value in values if isinstance(value, float | int) and not isinstance(value, bool)]
    if len(numbers) < len(values):
        return [yes_or_no(value) if isinstance(value, bool) else str(value) for value in values]
    unit, factor = common_unit(numbers, field_at(loops[0], path).unit)
    short, full = ([f"{factor * value:.{digits}g} {unit}".strip() for value in numbers] for digits in (5, 17))
    return short if len(set(short)) == len(set(numbers)) else full
