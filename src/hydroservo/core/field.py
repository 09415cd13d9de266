"""The declaration of one number: its unit, meaning, source and range."""

import math
import re
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import get_type_hints

CONTROLLED = "y"  # in a unit: that of the signal which a loop controls; in a meaning "{y}" is its name
OPEN = math.inf  # a number that is left open, as Field(auto=OPEN) declares it; "auto" in a scenario
FACTOR = re.compile(r"([^\s/()^]+)(?:\^(\([^)]*\)|[^\s/()]+))?")


@dataclass(frozen=True, slots=True)
class Field:
    """What one number of a block or state is: its unit, its meaning, its source, its range.

    Attributes:
        unit: SI unit, written as pint reads it ("kg", "m^3/(s Pa)"; "" is dimensionless). The name y in it,
            as in "V s/y", stands for the unit of the signal that the loop controls.
        meaning: what the number is, in the field's standard term. "{y}" in it stands for the name of the
            signal that the loop controls.
        source: where the default comes from ("" for a state field).
        above: exclusive lower bound, in ``unit``.
        at_least: inclusive lower bound, in ``unit``.
        below: exclusive upper bound, in ``unit``.
        at_most: inclusive upper bound, in ``unit``.
        derived: computed from other parameters before a run, and not to be given.
        auto: the number that asks for the value to be found, "auto" in a scenario; it need be in no range.
        smaller_is_better: of a metric; False says that more of it is not worse.
        least_is_worst: of a metric, among those of many runs.
        over: of a curve, the SI unit of what it is over; that of a recorded signal is s.
    """

    unit: str
    meaning: str
    source: str = ""
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    derived: bool = False
    auto: float | None = None
    smaller_is_better: bool = False
    least_is_worst: bool = False
    over: str = "s"

    def __post_init__(self) -> None:
        if not all(isinstance(text, str) for text in (self.unit, self.meaning, self.over)):
            given = f"{self.unit!r}, {self.meaning!r}"
            given += "" if isinstance(self.over, str) else f", over={self.over!r}"
            raise TypeError(f"the unit and the meaning of a Field are text, not {given}")

    def of(self, signal: "Field") -> "Field":
        """The declaration in a loop that controls a signal.

        Args:
            signal: the declaration of the controlled signal, its meaning a name such as "velocity".
        """
        return field_in_signal(self, signal.unit, signal.meaning)

    def __repr__(self) -> str:
        """Unit and meaning, and what else is said of the number."""
        others = ((one.name, getattr(self, one.name), one.default) for one in fields(self)[2:])
        said = [f"{name}={value!r}" for name, value, default in others if value != default]
        return f"Field({', '.join([repr(self.unit), repr(self.meaning), *said])})"


@cache
def field_in_signal(field: Field, unit: str, name: str) -> Field:
    """A declaration with the unit and the name of a controlled signal in it."""
    meaning = field.meaning.replace(f"{{{CONTROLLED}}}", name)
    own, over = (exchanged(one, CONTROLLED, unit) for one in (field.unit, field.over))
    return replace(field, unit=own, meaning=meaning, over=over)


@cache
def declared_fields(cls: Hashable) -> Mapping[str, Field]:
    """The :class:`Field` of each annotated number of a block or state class, by name."""
    hints = get_type_hints(cls, include_extras=True)
    found = {}
    for name, hint in hints.items():
        for note in getattr(hint, "__metadata__", ()):
            if isinstance(note, Field):
                found[name] = note
    return found


@cache
def exchanged(unit: str, name: str, other: str) -> str:
    """A unit with another in place of a name in it: "V s/y" with m/s for y is "V s^2/m".

    Args:
        unit: as a :class:`~hydroservo.core.field.Field` has it, "V/(y s)" for instance; returned as it is
            where the name is not in it.
        name: of what is exchanged.
        other: the unit that stands for it; "" is dimensionless.
    """
    if all(one != name for one, _ in powers(unit)):
        return unit
    found: dict[str, int] = {}
    for one, power in powers(unit):
        for own, exponent in powers(other) if one == name else [(one, 1)]:
            found[own] = found.get(own, 0) + exponent * power
    above = " ".join(unit_text(one, power) for one, power in found.items() if power > 0)
    below = [unit_text(one, -power) for one, power in found.items() if power < 0]
    if not below:
        return above
    return f"{above or 1}/{below[0] if len(below) == 1 else '(' + ' '.join(below) + ')'}"


def power_in(unit: str, name: str) -> int:
    """The power of a name in a unit: -1 of V in "m^3/(s V)", 0 where it is not in it."""
    return sum(power for one, power in powers(unit) if one == name)


def powers(unit: str) -> Iterator[tuple[str, int]]:
    """The names in a unit with their whole powers; of others, and of numbers, nothing."""
    above, _, below = unit.partition("/")
    for text, sign in ((above, 1), (below, -1)):
        for one, power in FACTOR.findall(text):
            if not one.isdigit() and (not power or power.lstrip("-").isdigit()):
                yield one, sign * int(power or 1)


def unit_text(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"
