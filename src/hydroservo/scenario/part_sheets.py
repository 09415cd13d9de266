"""A part as a data sheet: its numbers, the source of each, and what its block makes of them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import ParameterError, nearest
from hydroservo.scenario.build import draft_block
from hydroservo.scenario.part_curves import ASSUMED, SHEETS, PartSheet, no_sheet
from hydroservo.scenario.part_files import PartFile, expanded, part_texts, read_part
from hydroservo.scenario.registry import OWN, defaults, known_classes, makers, makers_in_role
from hydroservo.scenario.role_checks import ROLES
from hydroservo.scenario.tables import FileOrigin, Layer, LayeredTable, PartSource, TableEntry
from hydroservo.show import Finding
from hydroservo.show.html import html_of


class PartNumber(NamedTuple):
    """A number of a part as its file has it.

    Attributes:
        key: dotted, in the part.
        value: with its unit.
        source: document and page; empty where it is that of the part.
    """

    key: str
    value: str
    source: str = ""


class Part(NamedTuple):
    """A part: what it is, its numbers with their sources, and what its block then does.

    Attributes:
        name: of a built-in part, or the path of its file.
        title: what it is.
        source: of all numbers that have none of their own.
        role: of its block, such as Valve.
        numbers: of its file and of the parts that it names.
        assumed: what the sheet takes for what the part leaves to the machine.
        sheet: what follows.
    """

    name: str
    title: str
    source: str
    role: str
    numbers: tuple[PartNumber, ...]
    assumed: tuple[PartNumber, ...]
    sheet: PartSheet

    def finding(self) -> Finding:
        """What it says, as commands and notebooks show it."""
        from hydroservo.scenario.finding import part_finding

        return part_finding(self)

    def _repr_html_(self) -> str:
        return html_of(self.finding())


def parts(folder: str | Path | None = None) -> dict[str, str]:
    """The name and title of each built-in part, and of those in a folder of one's own.

    Args:
        folder: whose TOML files, and those of the folders in it, are parts too; none if None.

    Raises:
        ScenarioError: a file in the folder is not that of a part, in one line.
        ParameterError: there is no such folder.
    """
    return {name: about.title for name, about in part_sources(folder).items()}


def part_sources(folder: str | Path | None = None) -> dict[str, PartSource]:
    """What the files of parts say of them, by name or path."""
    if folder is not None and not Path(folder).is_dir():
        raise ParameterError("folder", str(folder), "must be a folder")
    own = sorted(Path(folder).rglob("*.toml")) if folder is not None else []
    return {name: named_part(name).about for name in (*part_texts(), *map(str, own))}


def named_part(name: str) -> PartFile:
    """A part by its name, or by a path from the current folder."""
    return read_part(TableEntry(FileOrigin("parts", Path()), "name", name))


def part(source: str | Path) -> Part:
    """A part with its sources and its data sheet.

    What a part leaves to the machine, such as the load of a cylinder, is assumed for the sheet alone.

    Args:
        source: the name of a built-in part such as ``cylinder/iso-6020-2-63-45``, or the path of a file.

    Raises:
        ScenarioError: there is no such part, or its file is not right, in one line.
    """
    name = str(source)
    file = named_part(name)
    layers = tuple(expanded(Layer(file.origin, file.table, file.about), [], (file,)))
    table = LayeredTable("", (Layer(file.origin, {}), *layers))
    role = role_of(table.entry("type"))
    assumed = assumed_for(role, table)
    beneath = Layer(FileOrigin("assumed for the sheet", Path()), assumed)
    draft = draft_block(role, None, table._replace(layers=(*table.layers, beneath)))
    rated = {path: one.value for path, one in draft.arguments()}
    return Part(
        name,
        file.about.title or name,
        file.about.source,
        role.__name__,
        tuple(numbers_of(table, file.about.source)),
        tuple(PartNumber(path, shown(entry.value)) for path, entry in LayeredTable("", (beneath,)).entries()),
        SHEETS.get(role, no_sheet)(draft.made(), rated),
    )


def role_of(entry: TableEntry) -> type:
    """The role of the block that a type makes."""
    for role in (*SHEETS, *ROLES):
        if isinstance(entry.value, str) and entry.value in makers_in_role(role):
            return role
    known = [name for cls in known_classes() for name in makers(cls)]
    raise entry.error(f"is not a type of a block{nearest(str(entry.value), known)}; {OWN}")


def assumed_for(role: type, table: LayeredTable) -> Mapping[str, Any]:
    """What stands in a sheet for what a part leaves out, of what its type takes."""
    taken = defaults(makers_in_role(role)[table.entry("type").value])
    values = ASSUMED.get(role, {}).items()
    return {name: value for name, value in values if name in taken and not table.has(name)}


def numbers_of(table: LayeredTable, source: str) -> list[PartNumber]:
    """The numbers of a part, each with its source where that is not the one of the part."""
    found = []
    for path, entry in table.entries():
        about = next(layer.part for layer in table.layers if layer.part and layer.origin is entry.origin)
        own = path.removeprefix(f"{about.table}.") if about.table else path
        said = about.sources.get(own, "" if about.source == source else about.source)
        found.append(PartNumber(path, shown(entry.value), said))
    return found


def shown(value: Any) -> str:
    """A value as a file has it."""
    return str(value).lower() if isinstance(value, bool) else str(value)
