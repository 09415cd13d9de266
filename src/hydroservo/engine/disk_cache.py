"""Machine code on disk: one file for each recipe, in the user's own cache directory.

What is loaded is run, so it must be this user's own. The folder and each file are opened once, and what was
opened is checked: its owner is this user, and nobody else may write it. Each file begins with a checksum of
its name and its content, so a file that is damaged or renamed never reaches the loader. Who can write as
this user can do all that this user can, and needs no cache for it.

A file that fails, or a directory that cannot be read or written, counts as no file: the code is made anew.
"""

import contextlib
import hashlib
import os
import secrets
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from platformdirs import user_cache_path

LARGEST = 2**28  # bytes kept; the files used longest ago go first
ENDING = ".kernel"
NEW = "new-"  # what is being written is called this
STALE = 3600.0  # s, after which nobody is still writing it
CHECK = hashlib.sha256().digest_size
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
POSIX = os.name == "posix"
# No link is followed, no pipe waited for, and no program that is started keeps the file open.
SAFELY = sum(getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"))


class CacheError(OSError):
    """What is there cannot be trusted; the message says why."""


class Folder(NamedTuple):
    """The cache's folder: by descriptor, so that it stays the one that was checked, where there are such."""

    place: Path
    descriptor: int | None

    def name(self, file: str) -> str:
        return file if self.descriptor is not None else str(self.place / file)

    def files(self, wanted: Callable[[str], bool]) -> Iterator[tuple[str, os.stat_result]]:
        """The files in it whose names are wanted; links are not followed."""
        with os.scandir(self.place if self.descriptor is None else self.descriptor) as entries:
            found = [entry for entry in entries if wanted(entry.name)]
        for entry in found:
            with contextlib.suppress(FileNotFoundError):  # another process removed it
                yield (
                    entry.name,
                    os.stat(self.name(entry.name), dir_fd=self.descriptor, follow_symlinks=False),
                )

    def read(self, file: str) -> bytes:
        """All of a file."""
        with os.fdopen(
            os.open(self.name(file), os.O_RDONLY | SAFELY, dir_fd=self.descriptor), "rb"
        ) as opened:
            found = os.fstat(opened.fileno())
            refuse_foreign(found, self.place / file)
            if not stat.S_ISREG(found.st_mode):
                raise CacheError(f"{self.place / file} is not a file")
            return opened.read()

    def touch(self, file: str) -> None:
        """Remember that a file was used now."""
        follow = os.utime not in os.supports_follow_symlinks
        with contextlib.suppress(OSError):  # a file system that is only read
            os.utime(self.name(file), dir_fd=self.descriptor, follow_symlinks=follow)

    def write(self, file: str, content: bytes) -> None:
        """A file with this content in the place of one that is there; others see all of it or nothing."""
        new = f"{NEW}{secrets.token_hex(8)}"
        here = self.descriptor
        try:
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | SAFELY
            with os.fdopen(os.open(self.name(new), flags, 0o600, dir_fd=here), "wb") as target:
                target.write(content)
            os.replace(self.name(new), self.name(file), src_dir_fd=here, dst_dir_fd=here)
        finally:
            self.remove(new)

    def remove(self, file: str) -> None:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.name(file), dir_fd=self.descriptor)


def directory() -> Path:
    """Where the files are: ``HYDROSERVO_CACHE_DIR``, else the platform's place for caches."""
    own = os.environ.get("HYDROSERVO_CACHE_DIR")
    if own:
        return Path(own).absolute()
    place = user_cache_path("hydroservo") / "kernels"
    if not place.is_absolute():
        raise CacheError("this user has no home directory; set HYDROSERVO_CACHE_DIR")
    return place


def read_kernel(digest: str) -> tuple[str, bytes] | None:
    """The name of a function and its object code; None if there is no file."""
    try:
        with open_folder() as folder:
            remove_leftovers(folder)
            content = verified_content(folder, digest)
            folder.touch(kernel_file(digest))
    except FileNotFoundError:
        return None
    name, _, code = content.partition(b"\0")
    return name.decode(), code


def verified_content(folder: Folder, digest: str) -> bytes:
    """What a file holds behind its checksum."""
    data = folder.read(kernel_file(digest))
    if data[:CHECK] != checksum(digest, data[CHECK:]):
        raise CacheError(f"{folder.place / kernel_file(digest)} is damaged")
    return data[CHECK:]


def write_kernel(digest: str, name: str, code: bytes) -> None:
    """Keep object code; other processes see all of it or nothing."""
    make_folder(directory())
    content = name.encode() + b"\0" + code
    with open_folder() as folder:
        folder.write(kernel_file(digest), checksum(digest, content) + content)
        remove_leftovers(folder)
        make_room(folder)


def kernel_file(digest: str) -> str:
    return f"{digest}{ENDING}"


def checksum(digest: str, content: bytes) -> bytes:
    return hashlib.sha256(digest.encode() + b"\0" + content).digest()


def make_folder(place: Path) -> None:
    """The folder, if there is none yet; but not among the files of another user, as root could."""
    if place.exists():
        return
    if POSIX:
        above = next(parent for parent in place.parents if parent.exists())
        if above.stat().st_uid not in (0, os.getuid()):
            raise CacheError(f"{above} belongs to another user")
    place.mkdir(mode=0o700, parents=True, exist_ok=True)


@contextmanager
def open_folder() -> Iterator[Folder]:
    """The folder, checked: it is this user's, and nobody else may write it."""
    place = directory()
    descriptor = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC) if POSIX else None
    try:
        refuse_foreign(place.stat() if descriptor is None else os.fstat(descriptor), place)
        yield Folder(place, descriptor)
    finally:
        if descriptor is not None:
            os.close(descriptor)


def refuse_foreign(found: os.stat_result, path: Path) -> None:
    """Refuse what others may have made; on Windows a user's profile is the user's own.

    Raises:
        CacheError: it belongs to another user, or others may write it.
    """
    if POSIX and found.st_uid != os.getuid():
        raise CacheError(f"{path} belongs to another user")
    if POSIX and found.st_mode & OTHERS_WRITE:
        raise CacheError(f"{path} is open to other users")


def remove_leftovers(folder: Folder) -> None:
    """Remove what was left half written by a process that was killed."""
    for file, found in folder.files(lambda file: file.startswith(NEW)):
        if time.time() - found.st_mtime > STALE:
            with contextlib.suppress(OSError):  # a file system that is only read
                folder.remove(file)


def make_room(folder: Folder) -> None:
    """Remove the files used longest ago until all of the cache's are small enough."""
    files = list(folder.files(lambda file: file.endswith(ENDING) or file.startswith(NEW)))
    size = sum(found.st_size for _, found in files)
    for file, found in sorted(files, key=lambda item: item[1].st_mtime):
        if size > LARGEST and file.endswith(ENDING):
            folder.remove(file)
            size -= found.st_size
