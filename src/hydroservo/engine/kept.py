"""What is kept on disk, whose it is, whether it would be loaded, and how it is cleared."""

from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hydroservo.engine.disk_cache import ENDING, KEY, NEW, CacheError, checked, directory, opened

__all__ = ["Kept", "clear", "kept"]


class Kept(NamedTuple):
    """The cache as it is.

    Attributes:
        place: its folder.
        exists: whether it is there; it is made with the first kernel.
        kernels: how many files there are.
        bytes: how many those have.
        owner: whose folder it is; "" where that cannot be told.
        problem: why nothing in it is loaded; "" if it is trusted.
        refused: why some of its files are not loaded, by their names.
    """

    place: Path
    exists: bool
    kernels: int
    bytes: int
    owner: str
    problem: str
    refused: dict[str, str]


def kept() -> Kept:
    """What is kept; each file is asked what it is asked before it is loaded.

    Raises:
        CacheError: this user has no home.
        OSError: the folder cannot be read.
    """
    place = directory()
    if not place.exists():
        return Kept(place, False, 0, 0, "", "", {})
    files = {path.name: path.lstat().st_size for path in place.glob(f"*{ENDING}")}
    found = Kept(place, True, len(files), sum(files.values()), owner_of(place), "", {})
    try:
        with opened() as folder:
            for file in sorted(files):
                try:
                    checked(folder, file.removesuffix(ENDING))
                except OSError as error:
                    found.refused[file] = error.strerror or str(error)
    except CacheError as error:
        return found._replace(problem=str(error))
    return found


def clear() -> int:
    """Remove all kernels and the key that they are signed with, and the folder if nothing else is in it.

    Returns:
        How many kernels there were.

    Raises:
        CacheError: it is another user's folder, or this user has no home.
        OSError: a file cannot be removed.
    """
    try:
        with opened(forbidden=0) as folder:
            names = [name for name, _ in folder.files(is_ours)]
            for name in names:
                folder.remove(name)
    except FileNotFoundError:
        return 0
    with suppress(OSError):  # something else is in it
        directory().rmdir()
    return sum(name.endswith(ENDING) for name in names)


def is_ours(name: str) -> bool:
    return name == KEY or name.endswith(ENDING) or name.startswith(NEW)


def owner_of(place: Path) -> str:
    """The name of a folder's owner, or the number where it has no name."""
    try:
        return place.owner()
    except KeyError:
        return str(place.stat().st_uid)
    except NotImplementedError:  # on Windows
        return ""
