"""What is built in: the texts of scenarios and studies, with their titles."""

import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable


def titles(room: str) -> dict[str, str]:
    """The name and title of each; without a title it is only what others build on."""
    found = {name: tomllib.loads(text).get("title") for name, text in texts(room).items()}
    return {name: title for name, title in found.items() if title is not None}


@cache
def texts(room: str) -> dict[str, str]:
    """The TOML texts of a room, by name, with those of what they build on.

    Args:
        room: ``scenario`` or ``studies``.
    """
    return dict(sorted(texts_in(files("hydroservo") / room / "builtin", "")))


def texts_in(folder: Traversable, prefix: str) -> Iterator[tuple[str, str]]:
    for item in folder.iterdir():
        if item.is_dir():
            yield from texts_in(item, f"{prefix}{item.name}/")
        elif item.name.endswith(".toml"):
            yield prefix + item.name.removesuffix(".toml"), item.read_text(encoding="utf-8")
