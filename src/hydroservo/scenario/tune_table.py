"""The search of a scenario's numbers, as its table ``[tune]`` has it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.block import field_at, leaves, value_at
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.field import declared_fields
from hydroservo.core.validation import checked_number
from hydroservo.linear.stability import Bounds
from hydroservo.runs.objective import (
    checked_effort,
    checked_weights,
    checked_whole,
    finite_numbers,
    metric_field,
)
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.ranges import both_ends, check_path
from hydroservo.scenario.scenario_files import named_source
from hydroservo.scenario.tables import LayeredTable, TableEntry

SEARCHED = ("controller", "sensors")  # what a search may set; the rest is given
LIMITS = {"gain_margin": "dB", "phase_margin": "rad", "max_sensitivity": "dB"}  # bounds, by name
PARTS = (  # of a search, by name
    *("weights", "scales", "metric", "seeds", "effort", "candidates", "seed", "bounded"),
    *LIMITS,
)


class SearchedRange(NamedTuple):
    """Between what a number is searched, in SI units."""

    low: float
    high: float
    entry: TableEntry  # where that is said


class SearchSettings(NamedTuple):
    """How numbers of a scenario are searched, as ``hydroservo tune`` does it."""

    ranges: Mapping[str, SearchedRange] = {}  # by path, in the order in which they count
    scenarios: Sequence[str | Path] = ()  # that are to share what is found, in this order; none: it alone
    weights: Sequence[float] = ()  # of each of these, or of as many others; none: all 1
    scales: Sequence[float] = ()  # of the uncertainty; none: each scenario's own
    metric: str = "rms_error"
    seeds: int = 1
    effort: float = 0.0
    candidates: int = 4096
    seed: int = 0  # of the search
    bounded: bool = True  # by margins, and by oscillation
    gain_margin: float = Bounds().gain_margin
    phase_margin: float = Bounds().phase_margin
    max_sensitivity: float = Bounds().max_sensitivity
    lost: TableEntry | None = None  # a range of a base whose path is none any more
    together: TableEntry | None = None  # where the scenarios stand

    @property
    def bounds(self) -> Bounds | None:
        """What the loops are to bear; None where the search has no bounds."""
        if not self.bounded:
            return None
        return Bounds(self.gain_margin, self.phase_margin, self.max_sensitivity)


def tune_search(scenario: LayeredTable, loop: Loop, arguments: Mapping[str, object]) -> SearchSettings:
    """What the table ``[tune]`` of a scenario says; where it is silent, the defaults.

    A range that a layer gives does not count if its path is none any more, or a number that the range is not
    of, because a layer above gives a block along it a type.
    """
    table = scenario.table("tune")
    table.check_keys(("vary", "scenarios", *PARTS))
    floats = {path for path, value in leaves(loop) if isinstance(value, float)}
    entries = dict(table.table("vary").entries())
    ranges: dict[str, SearchedRange] = {}
    lost: dict[str, TableEntry] = {}
    for path, entry in entries.items():
        of_another = scenario.has_type_above(entry.origin, path)
        if of_another and path not in floats:
            lost[path] = entry
            continue
        try:
            ranges[path] = searched_range(path, entry, loop, arguments)
        except ScenarioError:
            if not of_another:
                raise
            lost[path] = entry
    return SearchSettings(ranges, **checked_settings(table, loop), lost=next(iter(lost.values()), None))


def checked_settings(table: LayeredTable, loop: Loop) -> dict[str, Any]:
    """What the table ``[tune]`` of a loop says besides its ranges, checked."""
    found: dict[str, Any] = {}
    if table.has("scenarios"):
        found["together"] = table.entry("scenarios")
        found["scenarios"] = tuple(scenario_sources(found["together"]))
    count = len(found.get("scenarios", ()))
    for name in filter(table.has, PARTS):
        entry = table.entry(name)
        try:
            found[name] = checked_part(name, entry.value, count or scenario_count(entry.value), [loop])
        except ParameterError as error:
            raise entry.error(error.allowed) from None
    return found


def scenario_count(value: object) -> int:
    """How many scenarios a base weighs that leaves it to those above to name them."""
    return len(value) if isinstance(value, list) and value else 1


def searched_range(
    path: str, entry: TableEntry, loop: Loop, arguments: Mapping[str, object]
) -> SearchedRange:
    """Between what a number is searched."""
    if path.partition(".")[0] not in SEARCHED:
        problem = f"must be in the {' or '.join(SEARCHED)}, which a search may choose"
        raise ScenarioError(entry.origin.name, entry.key, problem)
    check_path(path, entry, loop, arguments)
    if path in arguments:
        problem = "is what a constructor takes; a search sets numbers of the block that it makes"
        raise ScenarioError(entry.origin.name, entry.key, problem)
    with commands_in(loop.command):
        return SearchedRange(*both_ends(entry, field_at(loop, path), float(value_at(loop, path))), entry)


def scenario_sources(entry: TableEntry) -> Iterator[str | Path]:
    """The scenarios that a list names."""
    if not isinstance(entry.value, list) or not entry.value:
        raise entry.error("must be a list of scenarios: built-in names, or paths of files")
    for name in entry.value:
        yield named_source(entry._replace(value=name))


def checked_part(name: str, value: object, count: int, loops: Sequence[Loop]) -> Any:
    """A part of a search besides its ranges and scenarios."""
    if name == "weights":
        return checked_weights(value, count, "scenario")
    if name == "scales":
        found = finite_numbers(value)
        if not found or len(set(found)) < len(found):
            raise ParameterError("scales", value, "must be different numbers")
        return found
    if name == "metric":
        metric_field(loops, value)
        return value
    if name in LIMITS:
        return checked_limit(name, value)
    if name == "bounded":
        if not isinstance(value, bool):
            raise ParameterError(name, value, "must be true or false")
        return value
    return checked_effort(value) if name == "effort" else checked_whole(name, value)


def checked_limit(name: str, value: object) -> float:
    """A bound on the margins: a text with its unit, such as "6 dB" or "30 deg"; a number in SI units."""
    unit, field = LIMITS[name], declared_fields(Bounds)[name]
    found = value
    if isinstance(value, str):
        try:
            found = factor_of(value) if unit == "dB" else si_value(value, unit)
        except (ValueError, OverflowError):
            example = "6 dB" if unit == "dB" else "30 deg"
            raise ParameterError(name, value, f"must be a number with its unit, such as {example}") from None
    try:
        return float(checked_number(found, name, field, float))
    except ParameterError as error:
        least = "must be above 0 dB" if name == "max_sensitivity" else "must be at least 0 dB"
        typed = isinstance(value, str) and unit == "dB"
        raise ParameterError(name, value, least if typed else error.allowed) from None


def factor_of(text: str) -> float:
    """The factor that a text in decibels is."""
    digits, unit, rest = text.partition("dB")
    if not unit or rest.strip():
        raise ValueError
    return float(10.0 ** (float(digits) / 20.0))
