"""The scenario that a page shows, and what was changed in it there."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import ScenarioError, short
from hydroservo.core.outputs import write_text
from hydroservo.scenario import Assembly, assemble
from hydroservo.scenario.layers import OVERRIDES, builtin_texts
from hydroservo.scenario.tables import parse_toml

PAGE = "the page's scenario"
MOST_CHANGES = 2000
MOST_TEXTS = 64  # each of a MiB at most
ONLY_GIVEN = "names a file, which a page may not read; start hydroservo app with this scenario"


class Home(NamedTuple):
    """What was said on the command line, and where the server keeps what a page sends.

    Attributes:
        given: the scenario, by name or path.
        plugins: files with blocks of one's own.
        folder: of the server's own, for what pages send.
    """

    given: str
    plugins: tuple[str, ...]
    folder: Path


class Source(NamedTuple):
    """A scenario with changes.

    Attributes:
        scenario: by name or path.
        changes: by dotted path, as ``--set`` takes them.
        plugins: files with its blocks, run when the server started.
        text: what a page sent; None for a scenario of the command line or a built-in one.
    """

    scenario: str | Path
    changes: Mapping[str, object]
    plugins: Sequence[str]
    text: str | None = None

    def assemble(self) -> Assembly:
        """The loop, and what it is made of.

        Raises:
            ScenarioError: the scenario does not say what it must.
        """
        return assemble(self.scenario, self.changes)


def page_source(request: Mapping[str, Any], home: Home) -> Source:
    """What a page asks for: ``{"text": ...}`` or ``{"name": ...}``, else what the command line gave."""
    changes = checked_changes(request.get("changes", {}))
    text, name = request.get("text"), request.get("name")
    if isinstance(text, str):
        check_encodes(text)
        check_reads_nothing(parse_toml(text, PAGE))
        return Source(keep_text(text, home.folder), changes, home.plugins, text)
    if isinstance(name, str) and name != home.given:
        if name not in builtin_texts():
            raise ScenarioError(PAGE, "", f"{short(name)} is not a built-in scenario")
        return Source(name, changes, home.plugins)
    return Source(home.given, changes, home.plugins)


def keep_text(text: str, folder: Path) -> Path:
    """The file that holds a text from a page; the files not used for longest are removed."""
    file = folder / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.toml"
    with suppress(FileNotFoundError):  # another worker may remove it at any time
        os.utime(file)
        return file
    with suppress(FileNotFoundError):
        for old in sorted(folder.glob("*.toml"), key=lambda kept: kept.stat().st_mtime)[: 1 - MOST_TEXTS]:
            old.unlink()
    return write_text(file, text)


def checked_changes(changes: object) -> Mapping[str, object]:
    """Changes that a page sent, which name no file."""
    if not isinstance(changes, Mapping) or len(changes) > MOST_CHANGES:
        raise ScenarioError(OVERRIDES, "", f"must be at most {MOST_CHANGES} values by path")
    for path, value in changes.items():
        if not isinstance(value, str | int | float):
            raise ScenarioError(OVERRIDES, str(path), "must be a string, a number, true or false")
        if str(path).rpartition(".")[2] == "file":
            raise ScenarioError(OVERRIDES, str(path), ONLY_GIVEN)
    return changes


def check_encodes(text: str) -> None:
    """Refuse a text with half of a character, a lone surrogate, as a page may send it."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        line = text.count("\n", 0, error.start) + 1
        raise ScenarioError(PAGE, f"line {line}", "has half of a character; delete it") from None


def check_reads_nothing(tables: Mapping[str, Any], key: str = "") -> None:
    """Refuse a text from a page that would have the server read files."""
    base = "" if key else tables.get("base", "")
    if not isinstance(base, str):
        raise ScenarioError(PAGE, "base", f"{short(base)} must be the name of a scenario, in quotes")
    if base and base not in builtin_texts():
        raise ScenarioError(PAGE, "base", f"{short(base)} {ONLY_GIVEN}")
    for name, value in tables.items():
        path = f"{key}.{name}" if key else name
        if isinstance(value, Mapping):
            check_reads_nothing(value, path)
        elif name == "file":
            raise ScenarioError(PAGE, path, f"{short(value)} {ONLY_GIVEN}")
