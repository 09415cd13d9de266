"""Built-in scenarios, and scenarios found by name or path."""

from pathlib import Path
from typing import TypeGuard

from hydroservo.builtin import texts, titles
from hydroservo.errors import ParameterError, ScenarioError, one_line, short
from hydroservo.inputs import exists, read_text
from hydroservo.nearest import nearest
from hydroservo.scenario.tables import Entry, Origin

LARGEST = 1 << 20  # bytes; a scenario is a few thousand
KINDS = {"scenario": "scenario", "studies": "study"}  # of what is built in, by its room


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
    return located(source)[1]


def located(source: str | Path, room: str = "scenario") -> tuple[Origin, str]:
    """Where a scenario comes from, and its text; or a study, in the room ``studies``."""
    kind = KINDS[room]
    if not isinstance(source, str | Path):
        raise ParameterError("source", source, f"must be the name of a {kind}, or the path of a file")
    if isinstance(source, str) and source in texts(room):
        return Origin(source, Path()), texts(room)[source]
    path, name = Path(source), one_line(str(source))
    if not exists(path):
        near = nearest(name, titles(room)) or nearest(path.name, beside(path))
        raise ScenarioError(name, "", f"there is no such file, and no built-in {kind} of that name{near}")
    return Origin(name, path.parent), read_text(path, LARGEST, name)


def beside(path: Path) -> list[str]:
    """The names of TOML files in the folder of a path; none where it cannot be listed."""
    try:
        return [one.name for one in path.parent.glob("*.toml")]
    except (OSError, ValueError):
        return []


def named_source(entry: Entry) -> str | Path:
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
