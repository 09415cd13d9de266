"""The scenario that a page shows, and what was changed in it there."""

import hashlib
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import ScenarioError, short
from hydroservo.core.outputs import write_text
from hydroservo.scenario import Assembly, assemble, scenario_source
from hydroservo.scenario.build import Draft
from hydroservo.scenario.part_files import PART, part_texts
from hydroservo.scenario.scenario_files import OVERRIDES, builtin_texts, nest_changes
from hydroservo.scenario.tables import parse_toml

Report = Callable[[float, str], None]  # called with the fraction done, and what is being done
PAGE = "the page's scenario"
MOST_CHANGES = 2000
MOST_TEXTS = 64  # each of a MiB at most
ONLY_GIVEN = "names a file, which a page may not read; start hydroservo app with this scenario"


class Home(NamedTuple):
    """What was said on the command line, and where the server keeps what a page sends."""

    given: str  # the scenario, by name or path
    plugins: tuple[str, ...]  # files with blocks of one's own
    folder: Path  # of the server's own, for what pages send


class Source(NamedTuple):
    """A scenario with changes."""

    scenario: str | Path  # by name or path
    changes: Mapping[str, object]  # by dotted path, as ``--set`` takes them
    text: str | None = None  # what a page sent; None for a scenario of the command line or a built-in one

    def assemble(self) -> Assembly:
        """The loop, and what it is made of."""
        return assemble(self.scenario, self.changes)


def page_source(request: Mapping[str, Any], home: Home) -> Source:
    """What a page asks for: ``{"text": ...}`` or ``{"name": ...}``, else what the command line gave."""
    changes = checked_changes(request.get("changes", {}))
    text, name = request.get("text"), request.get("name")
    if isinstance(text, str):
        check_encodes(text)
        check_reads_nothing(parse_toml(text, PAGE))
        return Source(keep_text(text, home.folder), changes, text)
    if isinstance(name, str) and name != home.given:
        if name not in builtin_texts():
            raise ScenarioError(PAGE, "", f"{short(name)} is not a built-in scenario")
        return Source(name, changes)
    return Source(home.given, changes)


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
        if reads_file(str(path).rpartition(".")[2], value):
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
        elif reads_file(name, value):
            raise ScenarioError(PAGE, path, f"{short(value)} {ONLY_GIVEN}")


def reads_file(name: str, value: object) -> bool:
    """Whether a key with a value would have the server read a file."""
    return name == "file" or (name == PART and isinstance(value, str) and value not in part_texts())


def page_scenario_text(source: Source) -> str:
    """TOML that gives the loop of the page.

    On a built-in scenario it builds by ``base``; a file's own text is written with the changes in it, and
    keeps its base.
    """
    import tomli_w

    made, changes = source.assemble(), nest_changes(source.changes)
    if str(source.scenario) in builtin_texts():
        return tomli_w.dumps({"base": str(source.scenario), **changes})
    text = source.text or scenario_source(source.scenario)
    if not changes:
        return text
    tables = parse_toml(text, str(source.scenario))
    return tomli_w.dumps(merge_changes(tables, changes, made))


def merge_changes(tables: Mapping[str, Any], changes: Mapping[str, Any], made: Assembly) -> dict[str, Any]:
    """A file's tables with changes in them, without what another type does not have."""
    found = merge_tables(tables, changes)
    for name, draft in made.drafts.items():
        if isinstance(found.get(name), dict):
            found[name] = keep_known_keys(found[name], draft)
    return found


def merge_tables(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(below)
    for name, value in above.items():
        old = found.get(name)
        found[name] = (
            merge_tables(old, value) if isinstance(value, Mapping) and isinstance(old, Mapping) else value
        )
    return found


def keep_known_keys(table: Mapping[str, Any], draft: Draft) -> dict[str, Any]:
    kept = {name: value for name, value in table.items() if name in ("type", PART) or name in draft.members}
    for name, value in kept.items():
        inner = draft.members.get(name)
        if isinstance(value, Mapping) and isinstance(inner, Draft):
            kept[name] = keep_known_keys(value, inner)
    return kept
