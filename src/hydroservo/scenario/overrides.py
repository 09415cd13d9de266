"""Changes to a scenario by dotted path."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from hydroservo.errors import ScenarioError, short
from hydroservo.scenario.tables import DEEPEST

PATH = re.compile(r"[\w-]+(?:\.[\w-]+)*")
OVERRIDES = "overrides"
LONGEST = 4096  # characters of one override


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


def nested(changes: Mapping[str, object]) -> dict[str, Any]:
    """Changes by dotted path as nested tables."""
    tables: dict[str, Any] = {}
    for path, value in flat(changes, ""):
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


def flat(changes: Mapping[str, object], prefix: str) -> Iterator[tuple[str, object]]:
    """Dotted paths and what is given at each: values, and tables only if they are empty."""
    for name, value in changes.items():
        path = f"{prefix}{name}"
        if not isinstance(name, str) or not PATH.fullmatch(name):
            raise ScenarioError(OVERRIDES, short(path), "must be a dotted path such as plant.mass")
        if path.count(".") >= DEEPEST:
            raise ScenarioError(OVERRIDES, short(path), f"must have at most {DEEPEST} parts")
        if isinstance(value, Mapping) and value:
            yield from flat(value, f"{path}.")
        else:
            yield path, value
