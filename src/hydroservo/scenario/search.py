"""The search of a scenario's numbers, as its table ``[tune]`` has it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.block import field_at, leaves, value_at
from hydroservo.errors import ScenarioError
from hydroservo.loop import Loop
from hydroservo.metrics import judged_by
from hydroservo.nearest import one_of
from hydroservo.scenario.catalogue import named_source
from hydroservo.scenario.ranges import both_ends, check_path
from hydroservo.scenario.tables import Entry, Table

__all__ = ["READERS", "Range", "Search", "searched_range", "tune_search"]

SEARCHED = ("controller", "sensors")  # what a search may set; the rest is given
MOST_CANDIDATES = 10_000_000
MOST_SEEDS = 10_000
LARGEST_SEED = 2**63 - 1
LARGEST = 1e300  # of weights, scales and effort


class Range(NamedTuple):
    """Between what a number is searched, in SI units."""

    low: float
    high: float
    entry: Entry  # where that is said


class Search(NamedTuple):
    """How numbers of a scenario are searched, as ``hydroservo tune`` does it."""

    ranges: Mapping[str, Range] = {}  # by path, in the order in which they count
    scenarios: Sequence[str | Path] = ()  # that are to share what is found, in this order; none: it alone
    weights: Sequence[float] = ()  # of each of these in the geometric mean; none: all 1
    scales: Sequence[float] = ()  # of the uncertainty; none: each scenario's own
    metric: str = "rms_error"
    seeds: int = 1
    effort: float = 0.0
    candidates: int = 4096
    seed: int = 0  # of the search


def tune_search(scenario: Table, loop: Loop, arguments: Mapping[str, object]) -> Search:
    """What the table ``[tune]`` of a scenario says; where it is silent, the defaults.

    A range that a layer gives does not count if its path is none any more, because a layer above gives a
    block along it a type.

    Args:
        scenario: all its tables.
        loop: what they describe.
        arguments: what constructors take, by path, which a search cannot set.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
    """
    table = scenario.table("tune")
    keys = ("vary", "scenarios", *READERS)
    for name in table.names():
        if name not in keys:
            raise table.entry(name).unknown(name, keys)
    found: dict[str, Any] = {name: read(name, table.entry(name)) for name in READERS if table.has(name)}
    if "metric" in found and found["metric"] not in (known := judged_by([loop])):
        raise table.entry("metric").error(one_of(found["metric"], known))
    if table.has("scenarios"):
        found["scenarios"] = tuple(sources(table.entry("scenarios")))
    count = len(found.get("scenarios", ())) or 1
    if len(found.get("weights", ())) not in (0, count):
        raise table.entry("weights").error(f"must be a number above 0 for each scenario; there are {count}")
    floats = {path for path, value in leaves(loop) if isinstance(value, float)}
    ranges = {
        path: searched_range(path, entry, loop, arguments)
        for path, entry in table.table("vary").entries()
        if path in floats or not scenario.has_type_above(entry.origin, path)
    }
    return Search(ranges, **found)


def searched_range(path: str, entry: Entry, loop: Loop, arguments: Mapping[str, object]) -> Range:
    """Between what a number is searched.

    Args:
        path: the number's.
        entry: its range, as text.
        loop: whose number it is; percentages are of its value there.
        arguments: what constructors take, by path.

    Raises:
        ScenarioError: a search may not set it, or there is no such number or range.
    """
    if path.partition(".")[0] not in SEARCHED:
        problem = f"must be in the {' or '.join(SEARCHED)}, which a search may choose"
        raise ScenarioError(entry.origin.name, entry.key, problem)
    check_path(path, entry, loop, arguments)
    if path in arguments:
        problem = "is what a constructor takes; a search sets numbers of the block that it makes"
        raise ScenarioError(entry.origin.name, entry.key, problem)
    return Range(*both_ends(entry, field_at(loop, path), float(value_at(loop, path))), entry)


def sources(entry: Entry) -> Iterator[str | Path]:
    """The scenarios that a list names."""
    if not isinstance(entry.value, list) or not entry.value:
        raise entry.error("must be a list of scenarios: built-in names, or paths of files")
    for name in entry.value:
        yield named_source(entry._replace(value=name))


def read(name: str, entry: Entry) -> Any:
    """The value of a key other than ``vary`` and ``scenarios``.

    Raises:
        ScenarioError: it is not what it must be.
    """
    try:
        return READERS[name](entry.value)
    except ValueError as error:
        raise entry.error(str(error)) from None


def weights(value: object) -> tuple[float, ...]:
    found = numbers(value)
    if not found or min(found) <= 0.0:
        raise ValueError("must be a number above 0 for each scenario")
    return found


def scales(value: object) -> tuple[float, ...]:
    found = numbers(value)
    if not found or len(set(found)) < len(found):
        raise ValueError("must be different numbers")
    return found


def effort(value: object) -> float:
    found = numbers([value])
    if not found or found[0] < 0.0:
        raise ValueError("must be a finite number from 0 on")
    return found[0]


def numbers(value: object) -> tuple[float, ...]:
    """The numbers in a list; none where it holds anything but finite numbers, or is no list."""
    found = value if isinstance(value, (list, tuple)) else ()
    return tuple(map(float, found)) if all(map(is_number, found)) else ()


def is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < LARGEST


def metric(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError("must be the name of a metric")
    return value


def whole(least: int, most: int) -> Callable[[object], int]:
    """A reader of whole numbers."""

    def found(value: object) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise ValueError(f"must be a whole number from {least} to {most}")
        return value

    return found


READERS: Mapping[str, Callable[[object], Any]] = {  # each raises a ValueError that says what is allowed
    "weights": weights,
    "scales": scales,
    "metric": metric,
    "seeds": whole(1, MOST_SEEDS),
    "effort": effort,
    "candidates": whole(1, MOST_CANDIDATES),
    "seed": whole(0, LARGEST_SEED),
}
