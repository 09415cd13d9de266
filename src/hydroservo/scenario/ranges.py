"""Ranges of numbers of a loop, such as "0.1..30 V s/m", "-50%..+100%" or "x0.5..x2"."""

import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, field_at, is_block, leaves
from hydroservo.core.errors import ScenarioError, nearest, one_of, short
from hydroservo.core.field import Field
from hydroservo.core.formatting import KELVIN, Scale, is_number
from hydroservo.core.validation import allowed, within
from hydroservo.runs.columns import SEED
from hydroservo.scenario.quantities import si_value, unit_factor
from hydroservo.scenario.tables import FileOrigin, TableEntry

SIGNS = ("+", "-", "\N{MINUS SIGN}")
QUANTITY = re.compile(r"[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?(?:\s*/\s*[0-9]+)?\s*(.*)", re.DOTALL)


class Relative(NamedTuple):
    """A range around the value that a number has."""

    low: float
    high: float


def relative(low: float, high: float) -> Relative:
    """A range around the value that a number has: ``relative(-0.3, 0.3)`` is 30 % less to 30 % more.

    Args:
        low: relative deviation at one end.
        high: at the other.
    """
    return Relative(low, high)


def as_entries(ranges: Mapping[str, object], name: str = "ranges") -> dict[str, TableEntry]:
    """Ranges by path as if a file had given them."""
    return {path: TableEntry(FileOrigin(name, Path()), path, value) for path, value in ranges.items()}


def check_path(path: str, entry: TableEntry, loop: Loop, arguments: Collection[str]) -> None:
    """Refuse what is not a number that can differ between runs."""
    if (path in arguments or is_float(loop, path)) and can_vary(path):
        return
    numbers = [path for path, value in leaves(loop) if isinstance(value, float)]
    given = (number for number in numbers if not field_at(loop, number).derived)
    known = [known for known in dict.fromkeys((*arguments, *given)) if can_vary(known)]
    parent = path.rpartition(".")[0]
    beside = [name for name in known if parent and name.rpartition(".")[0] == parent]
    problem = one_of(path, beside) if beside else f"is not a number that can vary{nearest(path, known)}"
    if path == SEED:
        problem = "is varied by --seeds"
    raise ScenarioError(entry.origin.name, entry.key, problem)


def is_float(block: Block, path: str) -> bool:
    value = block
    for name in path.split("."):
        if not is_block(value) or name not in value._fields:
            return False
        value = getattr(value, name)
    return isinstance(value, float)


def can_vary(path: str) -> bool:
    """False for what is common to all runs, and for what a scenario has no table for."""
    return not path.startswith(("simulation.", "hold.", "metrics."))


def both_ends(entry: TableEntry, field: Field, nominal: float | None) -> tuple[float, float]:
    """Both ends of a range in SI units, the lower one first.

    Args:
        entry: the text LOW..HIGH; one unit at its end serves both. A percentage with a sign at either end is
            relative to ``nominal``, "-50%..+100%", and so is a factor, "x0.5..x2"; one without a sign is a
            value, "0.1..3%", which a number with a unit does not have. From Python also two numbers in SI
            units, or a :class:`Relative`.
        field: the declaration of the number that it is for.
        nominal: the value that relative ranges are around; None where there is none.
    """
    try:
        ends = parse_ends(entry, field, nominal)
    except ValueError as error:
        raise ScenarioError(entry.origin.name, entry.key, f"{error}; it must be {allowed(field)}") from None
    for one in ends:
        if not within(one, field):
            raise entry.error(f"reaches {one:g}; it must be {allowed(field)}")
    low, high = sorted(ends)
    if low == high:
        raise entry.error(f"is not a range: both ends are {low:g}")
    return low, high


def parse_ends(entry: TableEntry, field: Field, nominal: float | None) -> tuple[float, float]:
    """Both ends of a range in SI units, as they are given."""
    value = entry.value
    if isinstance(value, tuple) and len(value) == 2 and all(map(is_number, value)):
        low, high = map(float, value)
        check_order(low, high, *value)
        if not isinstance(value, Relative):
            return low, high
        middle = middle_value(field, nominal)
        return middle * (1.0 + low), middle * (1.0 + high)
    if not isinstance(value, str) or ".." not in value:
        raise entry.error('must be a range, a string such as "0.1..30 V s/m", "-50%..+100%" or "x0.5..x2"')
    start, _, end = (part.strip() for part in value.partition(".."))
    return parse_two_quantities(start, end, field, nominal)


def typed_scales(ranges: Iterable[tuple[TableEntry, str]]) -> dict[str, Scale]:
    """The units in which ranges were typed, by SI unit: the first of each, and none of temperatures."""
    found: dict[str, Scale] = {}
    for entry, unit in ranges:
        typed = (
            unit_after_number(entry.value.partition("..")[2].strip()) if isinstance(entry.value, str) else ""
        )
        if typed and unit != KELVIN and (typed != "%" or not unit):
            found.setdefault(unit, Scale(typed, float(1 / unit_factor(typed, unit))))
    return found


def check_order(low: float, high: float, first: object, last: object) -> None:
    """Refuse a range whose ends are the wrong way round."""
    if low > high:
        raise ValueError(f"{short(first)} is more than {short(last)}, its upper end")


def middle_value(field: Field, nominal: float | None) -> float:
    """The value that a relative range is around."""
    if nominal is None:
        raise ValueError("is relative, and there is no value that it could be relative to")
    if nominal in (0.0, field.auto):
        present = "0" if nominal == 0.0 else '"auto"'
        raise ValueError(f"is {present} in the scenario, so no percentage of it can be taken")
    return nominal


def parse_two_quantities(low: str, high: str, field: Field, nominal: float | None) -> tuple[float, float]:
    """Two texts in SI units; one unit at the end serves both."""
    if low.startswith("x") and high.startswith("x"):
        factors = si_value_named(low[1:], ""), si_value_named(high[1:], "")
        check_order(*factors, low, high)
        middle = middle_value(field, nominal)
        return middle * factors[0], middle * factors[1]
    units = [unit_after_number(low), unit_after_number(high)]
    if units[1] and not units[0]:
        low, units[0] = f"{low} {units[1]}", units[1]
    percent = "%" in units
    plain = not any(units)
    unit = "" if percent or plain else field.unit
    if percent and units[1] != "%":
        raise ValueError(f"{short(high)} has no % while {short(low)} has one")
    ends = si_value_named(low, unit), si_value_named(high, unit)
    check_order(*ends, low, high)
    if percent and (low.startswith(SIGNS) or high.startswith(SIGNS)):
        middle = middle_value(field, nominal)
        return middle * (1.0 + ends[0]), middle * (1.0 + ends[1])
    if percent and field.unit:
        raise ValueError(f"{short(high)} {unsigned_percent_problem(*ends)}")
    return ends


def unsigned_percent_problem(low: float, high: float) -> str:
    """What to write in place of a percentage without a sign."""
    more, factors = f"+{100.0 * low:g}%..+{100.0 * high:g}%", f"x{low:g}..x{high:g}"
    return f"has no sign; write '{more}' for so much more than the value, or '{factors}' for so many times it"


def unit_after_number(text: str) -> str:
    """What follows the number in a quantity."""
    match = QUANTITY.fullmatch(text.replace("\N{MINUS SIGN}", "-"))
    return match[1] if match else ""


def si_value_named(text: str, unit: str) -> float:
    try:
        return si_value(text, unit)
    except ValueError as error:
        raise ValueError(f"{short(text)} {error}") from None
