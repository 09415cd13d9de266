"""Parts, such as a valve by its data sheet: tables in files of their own, which a scenario takes by name."""

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.builtin import texts_in
from hydroservo.core.errors import ScenarioError, nearest, short
from hydroservo.core.inputs import exists, read_text
from hydroservo.scenario.tables import (
    LARGEST,
    FileOrigin,
    Layer,
    LayeredTable,
    PartSource,
    TableEntry,
    parse_toml,
)

DIGITS = re.compile(r"(\d+)")
PART = "part"  # the key by which a table names its part
TITLE, SOURCE, SOURCES = ABOUT = ("title", "source", "sources")  # what a part's file says beside its table
CURVE = frozenset(("file", "points"))  # the keys of which a curve has one


class PartFile(NamedTuple):
    """The file of a part.

    Attributes:
        origin: as errors name it.
        place: equal for files that are the same.
        about: what it says of its numbers.
        table: its keys, as the table of a scenario has them.
    """

    origin: FileOrigin
    place: str | Path
    about: PartSource
    table: Mapping[str, Any]


@cache
def part_texts() -> dict[str, str]:
    """The TOML texts of the built-in parts, by name, in the order of the numbers in these."""
    found = texts_in(files("hydroservo") / "scenario" / "parts", "")
    return dict(sorted(found, key=lambda one: [int(n) if n.isdigit() else n for n in DIGITS.split(one[0])]))


def with_parts(layers: Iterable[Layer]) -> tuple[Layer, ...]:
    """Layers of a scenario, each with those of the parts that it names below it.

    A part stands for all numbers of its table: what the layers below give there does not count, nor in the
    tables that the part gives, for one device's numbers mean nothing to another. Of the tables that it does
    not give, such as the oil and the load of a cylinder, theirs count.
    """
    done: list[Layer] = []
    return tuple(one for layer in layers for one in expanded(layer, done))


def expanded(layer: Layer, done: list[Layer], above: tuple[PartFile, ...] = ()) -> Iterator[Layer]:
    """A layer without the names of its parts, then the layers of these.

    Args:
        layer: of a scenario's file, or of a part.
        done: the parts that lie over it; those of this layer are added.
        above: the parts that led to this layer, each named by the one before.
    """
    given = layer.given
    for one in done:
        given = beneath(given, one.part.table.split(".") if one.part and one.part.table else [], one.given)
    given, entries = without_parts(given, layer.origin, "", layer.part)
    yield layer._replace(given=given)
    for entry in sorted(entries, key=lambda one: -one.key.count(".")):  # a part within a part lies over it
        table = entry.key.rpartition(".")[0]
        part = read_part(entry, table)
        chain = (*above, part)
        if part.place in [one.place for one in above]:
            raise entry.error(f"makes a circle: {', '.join(one.origin.name for one in chain)}")
        new = list(expanded(Layer(part.origin, nested_at(table, part.table), part.about), done, chain))
        done += new
        yield from new


def beneath(given: Mapping[str, Any], path: list[str], part: Mapping[str, Any]) -> Mapping[str, Any]:
    """What counts of a table beneath a part at a path in it, whose own table stands at that path too."""
    if path:
        name, *rest = path
        if not isinstance(given.get(name), Mapping):
            return given
        return {**given, name: beneath(given[name], rest, part[name])}
    return {
        name: beneath(value, [], part[name]) if isinstance(part.get(name), Mapping) else value
        for name, value in given.items()
        if name == "type" or (isinstance(value, Mapping) and not is_curve(value))
    }


def is_curve(table: Mapping[str, Any]) -> bool:
    """Whether a table is that of a curve, which is a number of its block as any other."""
    return "type" not in table and not CURVE.isdisjoint(table)


def without_parts(
    given: Mapping[str, Any], origin: FileOrigin, path: str, part: PartSource | None
) -> tuple[Mapping[str, Any], list[TableEntry]]:
    """Tables without the names of parts in them, and these names.

    At the top of a scenario no part can be named, so the key stays there.
    """
    kept: dict[str, Any] = {}
    found: list[TableEntry] = []
    for name, value in given.items():
        key = f"{path}.{name}" if path else name
        if isinstance(value, Mapping):
            kept[name], more = without_parts(value, origin, key, part)
            found += more
        elif name == PART and (path or part):
            found.append(TableEntry(origin, key, value))
        else:
            kept[name] = value
    return (kept, found) if found else (given, found)


def nested_at(path: str, table: Mapping[str, Any]) -> Mapping[str, Any]:
    """A table at a dotted path."""
    for name in reversed(path.split(".") if path else []):
        table = {name: table}
    return table


def read_part(entry: TableEntry, table: str = "") -> PartFile:
    """The part that a value names: a built-in one, or a path from the folder of its own file.

    Args:
        entry: the name.
        table: the dotted key of the table that takes the part.

    Raises:
        ScenarioError: there is no such part, or its file is not that of one.
    """
    if not isinstance(entry.value, str):
        raise entry.error("must be a string: the name of a part, or the path of its file")
    if entry.value in part_texts():
        return builtin_part(entry.value, table)
    path = entry.origin.folder / entry.value
    if not exists(path):
        folder = short(str(entry.origin.folder.absolute()))
        near = nearest(entry.value, part_texts()) or "; `hydroservo parts` lists the built-in ones"
        raise entry.error(f"is not a built-in part, and there is no such file in {folder}{near}")
    origin = FileOrigin(str(path), path.parent)
    return parsed_part(origin, path.resolve(), read_text(path, LARGEST, origin.name), table)


@cache
def builtin_part(name: str, table: str) -> PartFile:
    """A built-in part, parsed once: none writes in it."""
    return parsed_part(FileOrigin(f"part {name}", Path()), name, part_texts()[name], table)


def parsed_part(origin: FileOrigin, place: str | Path, text: str, table: str) -> PartFile:
    """The part that a text is."""
    tables = parse_toml(text, origin.name)
    for name in (TITLE, SOURCE):
        if not isinstance(tables.get(name, ""), str):
            raise TableEntry(origin, name, tables[name]).error("must be a string")
    own = {name: value for name, value in tables.items() if name not in ABOUT}
    if "type" not in own and PART not in own:
        raise ScenarioError(origin.name, "type", "is missing: a part says which block it is")
    title, source = tables.get(TITLE, ""), tables.get(SOURCE, "")
    return PartFile(origin, place, PartSource(title, source, sources_in(tables, origin, own), table), own)


def sources_in(tables: Mapping[str, Any], origin: FileOrigin, own: Mapping[str, Any]) -> dict[str, str]:
    """The sources of single numbers, by the dotted keys of these."""
    known = [path for path, _ in LayeredTable("", (Layer(origin, own),)).entries()]
    found = {}
    said = LayeredTable("", (Layer(origin, {SOURCES: tables.get(SOURCES, {})}),)).table(SOURCES)
    for path, entry in said.entries():
        if path not in known:
            raise entry.unknown(path, known)
        if not isinstance(entry.value, str):
            raise entry.error("must be a string: document and page")
        found[path] = entry.value
    return found
