"""Tables of a scenario file, with what overrides them, and where each value came from."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.errors import ScenarioError, short
from hydroservo.nearest import one_of

__all__ = ["DEEPEST", "Entry", "Origin", "Table", "parsed"]

DEEPEST = 16  # tables within tables
KEY_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
# tomllib's time grows with the square of the parts of a dotted key: one line of them could take hours.
DEEP_KEY = re.compile(
    rf"^[ \t]*+(?:\[{{1,2}}[ \t]*+)?(?:{KEY_PART}[ \t]*+\.[ \t]*+){{{DEEPEST}}}", re.MULTILINE
)
TOO_DEEP = f"tables nested more than {DEEPEST} deep"


class Origin(NamedTuple):
    """Where values come from."""

    name: str  # as an error names it
    folder: Path  # what relative file names start from


class Entry(NamedTuple):
    """One value, with its dotted key and its origin."""

    origin: Origin
    key: str
    value: Any

    def error(self, problem: str) -> ScenarioError:
        """An error about this value."""
        return ScenarioError(self.origin.name, self.key, f"{short(self.value)} {problem}")

    def unknown(self, wrong: str, right: Iterable[str]) -> ScenarioError:
        """An error about this value's key, ``wrong``, and what it might be instead."""
        problem = f"unknown key (value {short(self.value)}); it {one_of(wrong, right)}"
        return ScenarioError(self.origin.name, self.key, problem)


class Table(NamedTuple):
    """A table of the file, and the changes to it."""

    origin: Origin
    path: str
    given: Mapping[str, Any]
    changes: Mapping[str, Any]

    def names(self) -> list[str]:
        """The keys in either, in order."""
        return list(dict.fromkeys((*self.given, *self.changes)))

    def has(self, name: str) -> bool:
        return name in self.given or name in self.changes

    def key(self, name: str) -> str:
        """The dotted key of a name in this table."""
        return f"{self.path}.{name}" if self.path else name

    def entry(self, name: str) -> Entry:
        """The value of a key, that of the changes first."""
        if name in self.changes:
            changed = Origin(f"{self.origin.name}, overridden", Path())
            return Entry(changed, self.key(name), self.changes[name])
        return Entry(self.origin, self.key(name), self.given[name])

    def table(self, name: str) -> "Table":
        """The nested table of a name; empty where there is none.

        Raises:
            ScenarioError: what is there is no table.
        """
        key = self.key(name)
        if name in self.changes and not isinstance(self.changes[name], Mapping):
            raise self.entry(name).error(f"must be a table: give {key}.type or the keys in it")
        given = self.given.get(name, {})
        if not isinstance(given, Mapping):
            raise Entry(self.origin, key, given).error(f"must be a table: [{key}]")
        return Table(self.origin, key, given, self.changes.get(name, {}))

    def retyped(self, default: str, names: Iterable[str]) -> "Table":
        """This table without what the file gives under other names, if its ``type`` is overridden."""
        type_given = self.given.get("type", default)
        if self.changes.get("type", type_given) == type_given:
            return self
        return self._replace(given={name: self.given[name] for name in names if name in self.given})

    def error(self, problem: str) -> ScenarioError:
        """An error about this table as a whole."""
        return ScenarioError(self.origin.name, self.path, problem)


def parsed(text: str, name: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Raises:
        ScenarioError: it is not TOML, or nested too deeply.
    """
    if DEEP_KEY.search(text):
        raise ScenarioError(name, "", TOO_DEEP)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(name, "", f"is not TOML: {error}") from None
    except RecursionError:
        raise ScenarioError(name, "", TOO_DEEP) from None
    except ValueError:  # Python converts no more than some thousand digits
        raise ScenarioError(name, "", "holds an integer of too many digits") from None
    if depth(tables) > DEEPEST:
        raise ScenarioError(name, "", TOO_DEEP)
    return tables


def depth(tables: Any) -> int:
    """How deep tables and arrays are nested, found without recursion; it stops beyond the limit."""
    level, found = [tables], 0
    while level and found <= DEEPEST:
        inner = [value for one in level for value in (one.values() if isinstance(one, dict) else one)]
        level, found = [value for value in inner if isinstance(value, (dict, list))], found + 1
    return found
