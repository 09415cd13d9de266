"""Scenarios that build on others: ``base = "rig/1khz"`` at the top of a file."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from hydroservo.errors import ScenarioError
from hydroservo.scenario.catalogue import builtin_texts, is_builtin, located, named_source, same_place
from hydroservo.scenario.overrides import OVERRIDES, nested
from hydroservo.scenario.tables import Entry, Layer, Origin, Table, parsed

BASE = "base"
MOST = 16  # files in a row, each the base of the one before


def layered(source: str | Path, changes: Mapping[str, object]) -> Table:
    """The tables of a scenario over those of what it builds on, and what overrides them on top.

    Args:
        source: a built-in name, or the path of a file.
        changes: values by dotted path.
    """
    overriding = nested(changes)
    if BASE in overriding:
        raise ScenarioError(OVERRIDES, BASE, "cannot be overridden; write a file of your own with that base")
    files = layers_of(source)
    origin = Origin(f"{files[0].origin.name}, overridden", Path())
    return Table("", (Layer(origin, overriding), *files))


def layers_of(source: str | Path) -> list[Layer]:
    """The tables of a file, of its base, of that one's base, and so on."""
    found: list[Layer] = []
    places: list[str | Path] = []
    while True:
        origin, text = located(source)
        tables = builtin_tables(source) if is_builtin(source) else parsed(text, origin.name)
        found.append(Layer(origin, {name: value for name, value in tables.items() if name != BASE}))
        if BASE not in tables:
            return found
        places.append(same_place(source))
        entry = Entry(origin, BASE, tables[BASE])
        source = named_source(entry)
        if same_place(source) in places:
            first = places.index(same_place(source))
            names = [layer.origin.name for layer in (*found[first:], found[first])]
            raise entry.error(f"makes a circle: {', '.join(names)}")
        if len(found) == MOST:
            raise entry.error(f"is one base too many: no more than {MOST} files may build on each other")


@cache
def builtin_tables(name: str) -> Mapping[str, Any]:
    """The tables of a built-in scenario, parsed once: many build on the same few, and none writes in them."""
    return parsed(builtin_texts()[name], name)
