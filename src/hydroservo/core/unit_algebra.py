"""Units as text with one name exchanged for another unit."""

import re
from collections.abc import Iterator
from functools import cache

FACTOR = re.compile(r"([^\s/()^]+)(?:\^(\([^)]*\)|[^\s/()]+))?")


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
