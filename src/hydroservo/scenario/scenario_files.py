"""Scenarios found by name or path, what they build on, and changes by dotted path."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeGuard

from hydroservo.core.builtin import texts, titles
from hydroservo.core.errors import ParameterError, ScenarioError, nearest, one_line, short
from hydroservo.core.inputs import exists, read_text
from hydroservo.scenario.part_files import with_parts
from hydroservo.scenario.tables import (
    DEEPEST,
    LARGEST,
    FileOrigin,
    Layer,
    LayeredTable,
    TableEntry,
    parse_toml,
)

KINDS = {"scenario": "scenario", "studies": "study"}  # of what is built in, by its room
PATH = re.compile(r"[\w-]+(?:\.[\w-]+)*")
OVERRIDES = "overrides"
LONGEST = 4096  # characters of one override
BASE = "base"
MOST = 16  # files in a row, each the base of the one before


def scenarios() -> dict[str, str]:
    """The name and title of each built-in scenario; without a title it is only what others build on."""
    return titles("scenario")


def scenario_source(source: str | Path) -> str:
    """The TOML text of a scenario, without that of its base.

    Args:
        source: a built-in name such as ``paper/sine-tsmc``, or the path of a file.

    Raises:
        ScenarioError: there is no such scenario, or its file cannot be read.
    """
    return locate_source(source)[1]


def locate_source(source: str | Path, room: str = "scenario") -> tuple[FileOrigin, str]:
    """Where a scenario comes from, and its text; or a study, in the room ``studies``."""
    kind = KINDS[room]
    if not isinstance(source, str | Path):
        raise ParameterError("source", source, f"must be the name of a {kind}, or the path of a file")
    if isinstance(source, str) and source in texts(room):
        return FileOrigin(source, Path()), texts(room)[source]
    path, name = Path(source), one_line(str(source))
    if not exists(path):
        near = nearest(name, titles(room)) or nearest(path.name, toml_files_beside(path))
        raise ScenarioError(name, "", f"there is no such file, and no built-in {kind} of that name{near}")
    return FileOrigin(name, path.parent), read_text(path, LARGEST, name)


def toml_files_beside(path: Path) -> list[str]:
    """The names of TOML files in the folder of a path; none where it cannot be listed."""
    try:
        return [one.name for one in path.parent.glob("*.toml")]
    except (OSError, ValueError):
        return []


def named_source(entry: TableEntry) -> str | Path:
    """The scenario that a value names: a built-in one, or a path from the folder of its own file."""
    if not isinstance(entry.value, str):
        raise entry.error("must be a string: the name of a built-in scenario, or the path of a file")
    if entry.value in builtin_texts():
        return entry.value
    path = entry.origin.folder / entry.value
    if not exists(path):
        folder = short(str(entry.origin.folder.absolute()))
        near = nearest(entry.value, builtin_texts())
        raise entry.error(f"is not a built-in name, and there is no such file in {folder}{near}")
    return path


def same_place(source: str | Path) -> str | Path:
    """Equal for sources that are the same scenario, however its path is written."""
    if is_builtin(source):
        return source
    try:
        return Path(source).resolve()
    except (OSError, RuntimeError, ValueError):  # a circle of links, a null character
        return Path(source)


def is_builtin(source: object) -> TypeGuard[str]:
    """Whether a source is the name of a built-in scenario."""
    return isinstance(source, str) and source in builtin_texts()


def builtin_texts() -> dict[str, str]:
    """The texts of the built-in scenarios, and of what they build on, by name."""
    return texts("scenario")


def parse_override(text: str) -> tuple[str, Any]:
    """The path and value of ``a.b.c=VALUE``, as the command line's ``--set`` takes it.

    VALUE is read as a TOML value if it is one (a number, true, a quoted string), else as a bare string
    such as 40 bar or TSMC.

    Raises:
        ScenarioError: the text is not of that form.
    """
    path, equals, value = text.partition("=")
    path = path.strip()
    if not equals or not PATH.fullmatch(path):
        raise ScenarioError(OVERRIDES, "", f"{short(text)} must be of the form a.b.c=VALUE")
    if len(text) > LONGEST:
        raise ScenarioError(OVERRIDES, path, f"is longer than {LONGEST} characters")
    return path, toml_value(value.strip())


def toml_value(text: str) -> Any:
    try:
        tables = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
        return text
    return tables["value"] if len(tables) == 1 else text


def nest_changes(changes: Mapping[str, object]) -> dict[str, Any]:
    """Changes by dotted path as nested tables."""
    tables: dict[str, Any] = {}
    for path, value in flatten_changes(changes, ""):
        *parents, name = path.split(".")
        table = tables
        for parent in parents:
            table = table.setdefault(parent, {})
            if not isinstance(table, dict):
                raise ScenarioError(OVERRIDES, path, f"{parent} is also given a value, so it is not a table")
        there, empty = isinstance(table.get(name), dict), isinstance(value, Mapping)
        if there and not empty:
            raise ScenarioError(
                OVERRIDES, path, f"{short(value)} is given where other overrides have a table"
            )
        if not there:
            table[name] = {} if empty else value
    return tables


def flatten_changes(changes: Mapping[str, object], prefix: str) -> Iterator[tuple[str, object]]:
    """Dotted paths and what is given at each: values, and tables only if they are empty."""
    for name, value in changes.items():
        path = f"{prefix}{name}"
        if not isinstance(name, str) or not PATH.fullmatch(name):
            raise ScenarioError(OVERRIDES, short(path), "must be a dotted path such as plant.mass")
        if path.count(".") >= DEEPEST:
            raise ScenarioError(OVERRIDES, short(path), f"must have at most {DEEPEST} parts")
        if isinstance(value, Mapping) and value:
            yield from flatten_changes(value, f"{path}.")
        else:
            yield path, value


def layered_table(source: str | Path, changes: Mapping[str, object]) -> LayeredTable:
    """The tables of a scenario over those of what it builds on, and what overrides them on top.

    Below each layer lie the parts that it names.
    """
    overriding = nest_changes(changes)
    if BASE in overriding:
        raise ScenarioError(OVERRIDES, BASE, "cannot be overridden; write a file of your own with that base")
    files = layers_of(source)
    origin = FileOrigin(f"{files[0].origin.name}, overridden", Path())
    return LayeredTable("", with_parts((Layer(origin, overriding), *files)))


def layers_of(source: str | Path) -> list[Layer]:
    """The tables of a file, of its base, of that one's base, and so on."""
    found: list[Layer] = []
    places: list[str | Path] = []
    while True:
        origin, text = locate_source(source)
        tables = builtin_tables(source) if is_builtin(source) else parse_toml(text, origin.name)
        found.append(Layer(origin, {name: value for name, value in tables.items() if name != BASE}))
        if BASE not in tables:
            return found
        places.append(same_place(source))
        entry = TableEntry(origin, BASE, tables[BASE])
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
    return parse_toml(builtin_texts()[name], name)
