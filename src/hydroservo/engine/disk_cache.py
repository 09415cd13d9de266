"""Machine code on disk: one file for each recipe, in the user's own cache directory.

Only what this user alone can write is loaded. A file that is damaged, or a directory that cannot be read or
written, counts as no file: the code is made anew.
"""

import contextlib
import hashlib
import os
import stat
import tempfile
from pathlib import Path

from platformdirs import user_cache_path

__all__ = ["directory", "read", "write"]

LARGEST = 2**28  # bytes kept; the files used longest ago go first
ENDING = ".kernel"
CHECK = hashlib.sha256().digest_size


def directory() -> Path:
    """Where the files are: ``HYDROSERVO_CACHE_DIR``, else the platform's place for caches."""
    own = os.environ.get("HYDROSERVO_CACHE_DIR")
    return Path(own) if own else user_cache_path("hydroservo") / "kernels"


def read(digest: str) -> tuple[str, bytes] | None:
    """The name of a function and its object code, or None."""
    path = file_of(digest)
    try:
        if not private(path.parent):
            return None
        data = path.read_bytes()
    except OSError:
        return None
    with contextlib.suppress(OSError):  # a file system that is only read
        os.utime(path)
    name, found, code = data[CHECK:].partition(b"\0")
    whole = hashlib.sha256(data[CHECK:]).digest() == data[:CHECK]
    return (name.decode(), code) if whole and found else None


def file_of(digest: str) -> Path:
    return directory() / f"{digest}{ENDING}"


def write(digest: str, name: str, code: bytes) -> None:
    """Keep object code; other processes see all of it or nothing."""
    content = name.encode() + b"\0" + code
    place = directory()
    with contextlib.suppress(OSError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not private(place):
            return
        with tempfile.NamedTemporaryFile(dir=place, prefix="new-", delete=False) as file:
            file.write(hashlib.sha256(content).digest() + content)
        Path(file.name).replace(file_of(digest))
        make_room(place)


def private(place: Path) -> bool:
    """True if nobody else can have put code there."""
    if not hasattr(os, "getuid"):
        return True
    found = place.stat()
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def make_room(place: Path) -> None:
    """Remove the files used longest ago until the rest is small enough."""
    files = sorted(
        ((path.stat(), path) for path in place.glob(f"*{ENDING}")), key=lambda item: item[0].st_mtime
    )
    size = sum(found.st_size for found, _ in files)
    for found, path in files:
        if size <= LARGEST:
            return
        path.unlink()
        size -= found.st_size
