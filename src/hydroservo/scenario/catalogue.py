"""Built-in scenarios, and scenarios found by name or path."""

import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from hydroservo.errors import ScenarioError, one_line
from hydroservo.nearest import nearest
from hydroservo.scenario.files import exists, read_text
from hydroservo.scenario.tables import Origin

__all__ = ["located", "scenario_source", "scenarios"]

LARGEST = 1 << 20  # bytes; a scenario is a few thousand


def scenarios() -> dict[str, str]:
    """The name and title of each built-in scenario."""
    return {name: tomllib.loads(text)["title"] for name, text in builtin_texts().items()}


def scenario_source(source: str | Path) -> str:
    """The TOML text of a scenario.

    Args:
        source: a built-in name such as ``paper/sine-tsmc``, or the path of a file.

    Raises:
        ScenarioError: there is no such scenario, or its file cannot be read.
    """
    return located(source)[1]


def located(source: str | Path) -> tuple[Origin, str]:
    """Where a scenario comes from, and its text."""
    if isinstance(source, str) and source in builtin_texts():
        return Origin(source, Path()), builtin_texts()[source]
    path, name = Path(source), one_line(str(source))
    if not exists(path):
        near = nearest(name, builtin_texts())
        raise ScenarioError(name, "", f"there is no such file, and no built-in scenario of that name{near}")
    return Origin(name, path.parent), read_text(path, LARGEST, name)


@cache
def builtin_texts() -> dict[str, str]:
    root = files("hydroservo.scenario") / "builtin"
    return dict(sorted(texts(root, "")))


def texts(folder: Traversable, prefix: str) -> Iterator[tuple[str, str]]:
    for item in folder.iterdir():
        if item.is_dir():
            yield from texts(item, f"{prefix}{item.name}/")
        elif item.name.endswith(".toml"):
            yield prefix + item.name.removesuffix(".toml"), item.read_text(encoding="utf-8")
