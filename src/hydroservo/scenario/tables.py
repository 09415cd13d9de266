"""Tables of a scenario, layer over layer, and where each value came from."""

import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import ScenarioError, one_of, short
from hydroservo.scenario.quantities import toml_slip

LAW = "controller"  # the table of a loop that holds what is tuned to one law
DEEPEST = 16  # tables within tables
LARGEST = 1 << 20  # bytes; a scenario is a few thousand
KEY_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
# tomllib's time grows with the square of the parts of a dotted key: one line of them could take hours.
DEEP_KEY = re.compile(
    rf"^[ \t]*+(?:\[{{1,2}}[ \t]*+)?(?:{KEY_PART}[ \t]*+\.[ \t]*+){{{DEEPEST}}}", re.MULTILINE
)
TOO_DEEP = f"tables nested more than {DEEPEST} deep"


class FileOrigin(NamedTuple):
    """Where values come from."""

    name: str  # as an error names it
    folder: Path  # what relative file names start from


class TableEntry(NamedTuple):
    """One value, with its dotted key and its origin."""

    origin: FileOrigin
    key: str
    value: Any

    def error(self, problem: str) -> ScenarioError:
        """An error about this value."""
        return ScenarioError(self.origin.name, self.key, f"{short(self.value)} {problem}")

    def unknown(self, wrong: str, right: Iterable[str], inside: Sequence[str] = ()) -> ScenarioError:
        """An error about this value's key, ``wrong``, and what it might be instead."""
        problem = f"unknown key (value {short(self.value)}); it {one_of(wrong, right)}"
        if inside:
            problem += f"; {wrong} is in {' and '.join(inside)}"
        return ScenarioError(self.origin.name, self.key, problem)


class PartSource(NamedTuple):
    """What the file of a part says of its numbers.

    Attributes:
        title: what the part is.
        source: of all numbers that have none of their own.
        sources: of single numbers, by their dotted keys in the part.
        table: the dotted key of the table that takes the part.
    """

    title: str
    source: str
    sources: Mapping[str, str]
    table: str


class Layer(NamedTuple):
    """What one file gives in a table, or what overrides the files."""

    origin: FileOrigin
    given: Mapping[str, Any]
    part: PartSource | None = None  # where the file is that of a part

    def with_keys(self, wanted: Callable[[str], bool]) -> "Layer":
        """The layer with those keys alone that are wanted."""
        return self._replace(given={name: value for name, value in self.given.items() if wanted(name)})


class LayeredTable(NamedTuple):
    """A table of a scenario, in layers: what overrides its files, its own file, then base upon base.

    Below each of them lie the parts that it names.
    """

    path: str
    layers: tuple[Layer, ...]  # the first that has a key gives its value

    @property
    def origin(self) -> FileOrigin:
        """What an error about the whole table names: that of the first layer that gives anything in it."""
        files = (layer.origin for layer in self.layers[1:] if layer.part is None)
        return next((layer.origin for layer in self.layers if layer.given), None) or next(files)

    def names(self) -> list[str]:
        """The keys in any layer, those of the lowest first."""
        return list(dict.fromkeys(name for layer in reversed(self.layers) for name in layer.given))

    def check_keys(self, known: Collection[str]) -> None:
        """Refuse a key that is none of those."""
        for name in self.names():
            if name not in known:
                raise self.entry(name).unknown(name, known)

    def has(self, name: str) -> bool:
        return any(name in layer.given for layer in self.layers)

    def with_key(self, name: str) -> list[str]:
        """The dotted keys of the tables in this one that have a key."""
        items = (item for layer in self.layers for item in layer.given.items())
        inner = (self.key(part) for part, value in items if isinstance(value, Mapping) and name in value)
        return list(dict.fromkeys(inner))

    def without(self, name: str) -> "LayeredTable":
        """This table without a key."""
        return self._replace(layers=tuple(layer.with_keys(name.__ne__) for layer in self.layers))

    def key(self, name: str) -> str:
        """The dotted key of a name in this table."""
        return f"{self.path}.{name}" if self.path else name

    def entry(self, name: str) -> TableEntry:
        """The value of a key, that of the first layer that has it."""
        layer = next(layer for layer in self.layers if name in layer.given)
        return TableEntry(layer.origin, self.key(name), layer.given[name])

    def entries(self, prefix: str = "") -> Iterator[tuple[str, TableEntry]]:
        """The values in this table and the tables in it, by their dotted paths after a prefix."""
        for name in self.names():
            entry = self.entry(name)
            if isinstance(entry.value, Mapping):
                yield from self.table(name).entries(f"{prefix}{name}.")
            else:
                yield prefix + name, entry

    def table(self, name: str) -> "LayeredTable":
        """The nested table of a name; empty where there is none."""
        key = self.key(name)
        layers = tuple(layer._replace(given=layer.given.get(name, {})) for layer in self.layers)
        for i, layer in enumerate(layers):
            if not isinstance(layer.given, Mapping):
                what = f"[{key}]" if i else f"give {key}.type or the keys in it"
                raise TableEntry(layer.origin, key, layer.given).error(f"must be a table: {what}")
        return LayeredTable(key, layers)

    def retyped(self, default: str, names: Callable[[TableEntry], Iterable[str]]) -> "LayeredTable":
        """This table without what a layer gives under keys that another ``type`` above it does not have.

        In a law, a file that names another type takes nothing of what those below give: gains of one law mean
        nothing to another, even under the same name. What overrides the files keeps what both have.
        """
        kept: list[Layer] = []
        present = default
        law = self.path.partition(".")[0] == LAW
        for layer in reversed(self.layers):
            wanted = layer.given.get("type", present)
            if wanted != present and any(below.given for below in kept):
                own = set(names(TableEntry(layer.origin, self.key("type"), wanted)))
                if law and present and layer is not self.layers[0]:
                    own = set()
                kept = [below.with_keys(own.__contains__) for below in kept]
            present = wanted
            kept.append(layer)
        return self._replace(layers=tuple(reversed(kept)))

    def has_type_above(self, origin: FileOrigin, path: str) -> bool:
        """Whether a layer above that of an origin gives a ``type`` to a table along a path in this one.

        That of the signal which a table controls counts too, as units depend on it.
        """
        above = [layer.given for layer in takewhile(lambda layer: layer.origin is not origin, self.layers)]
        for name in path.split(".")[:-1]:
            above = [given[name] for given in above if isinstance(given.get(name), Mapping)]
            signals = [given["controls"] for given in above if isinstance(given.get("controls"), Mapping)]
            if any("type" in given for given in (*above, *signals)):
                return True
        return False

    def beside_part(self) -> str:
        """Where a number is given that a part leaves out, to end a message with; nothing without a part."""
        parts = [layer.origin.name for layer in self.layers if layer.part and layer.given]
        return f"; give it beside {parts[0]}" if parts else ""

    def error(self, problem: str) -> ScenarioError:
        """An error about this table as a whole."""
        return ScenarioError(self.origin.name, self.path, problem)


def parse_toml(text: str, name: str) -> dict[str, Any]:
    if DEEP_KEY.search(text):
        raise ScenarioError(name, "", TOO_DEEP)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(name, "", f"is not TOML: {error}{toml_slip(text, str(error))}") from None
    except RecursionError:
        raise ScenarioError(name, "", TOO_DEEP) from None
    except ValueError:  # Python converts no more than some thousand digits
        raise ScenarioError(name, "", "holds an integer of too many digits") from None
    if nesting_depth(tables) > DEEPEST:
        raise ScenarioError(name, "", TOO_DEEP)
    return tables


def nesting_depth(tables: Any) -> int:
    """How deep tables and arrays are nested, found without recursion; it stops beyond the limit."""
    level, found = [tables], 0
    while level and found <= DEEPEST:
        inner = [value for one in level for value in (one.values() if isinstance(one, dict) else one)]
        level, found = [value for value in inner if isinstance(value, (dict, list))], found + 1
    return found
