"""Files that are written whole or not at all, those of a folder together.

They are written into a hidden folder beside their places and renamed at the end, one after the other with no
work in between. To exchange whole folders would be a single step, but would take along what else is in them.
A process killed between two renames leaves files of two runs; digests in the file renamed last tell which.
"""

import atexit
import errno
import hashlib
import os
import re
import secrets
import shutil
import signal
import stat
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from hydroservo.core.errors import HydroservoError, system_problem

if sys.platform != "win32":
    import fcntl

PREFIX = ".hydroservo-writing-"
STAGE = re.compile(re.escape(PREFIX) + "[0-9a-f]{8}")
LOCK = "in-use"
NOTE = b"A process of hydroservo is writing here; the next one removes what a killed one left.\n"

SIGNALS = [signal.SIGINT, signal.SIGTERM]
if sys.platform != "win32":
    SIGNALS += [signal.SIGHUP, signal.SIGALRM]
TEMPORARY: set[Path] = set()  # folders of this process


class OutputError(HydroservoError):
    """A file cannot be written."""


@contextmanager
def staged(folder: Path | str, last: str = "") -> Iterator[Path]:
    """A hidden folder in ``folder``, whose files take their places in ``folder`` together.

    Missing folders are made, files of the same names replaced, others left alone. On an error or an interrupt
    ``folder`` stays as it was. What a killed process leaves behind, the next one that writes there removes.

    Args:
        folder: where the files go.
        last: the file that takes its place after all others.
    """
    folder = Path(folder)
    with naming(folder), stage_in(folder) as stage:
        yield stage
        uninterrupted(lambda: move(stage, folder, last))


@contextmanager
def atomic_path(path: Path | str) -> Iterator[Path]:
    """A temporary path of the same name, which takes the place of ``path`` once written without error.

    Missing folders are made. On an error or an interrupt the temporary file is removed, and what was at
    ``path`` before is still there. Where ``path`` lies in a folder that :func:`staged` gave, it is ``path``.
    """
    path = Path(path)
    final = final_place(path)
    if final == path:
        with naming(path), stage_in(path.parent) as stage:
            yield stage / path.name
            uninterrupted(lambda: move(stage, path.parent))
        return
    with naming(final):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield path
        except BaseException:
            with suppress(OSError):
                path.unlink()
            raise


def final_place(path: Path) -> Path:
    """The path that a file will have; another than its own where that lies in a hidden folder."""
    staging = next((parent for parent in path.parents if STAGE.fullmatch(parent.name)), None)
    return path if staging is None else staging.parent / path.relative_to(staging)


def write_text(path: Path | str, text: str) -> Path:
    """Write a text file, whole or not at all; returns its path."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return Path(path)


def written_or_kept(folder: Path, write: Callable[[Path], Sequence[Path]]) -> Sequence[Path]:
    """Write files into a folder, all or none; if none, into a temporary folder that the error names."""
    try:
        return write(folder)
    except OutputError as error:
        raise keep_elsewhere(error, write) from None


def keep_elsewhere(problem: OutputError, write: Callable[[Path], object]) -> OutputError:
    """The problem, and where else the files are now, if they could be written to the temporary folder."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="hydroservo-"))
    except OSError:
        return problem
    try:
        write(folder)
    except BaseException as error:
        shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OutputError):
            return problem
        raise
    return OutputError(f"{problem}; kept in {folder} instead")


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder that is removed at the end, or where that does not come as the process ends."""
    folder = new_temporary_folder()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        TEMPORARY.discard(folder)


def new_temporary_folder() -> Path:
    """A folder that stays until the process ends."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="hydroservo-"))
    except OSError as error:
        raise OutputError(f"no temporary folder can be made: {system_problem(error)}") from None
    TEMPORARY.add(folder)
    return folder


def remove_temporary_folders() -> None:
    """Remove the temporary folders of this process, as it ends."""
    while TEMPORARY:
        shutil.rmtree(TEMPORARY.pop(), ignore_errors=True)


atexit.register(remove_temporary_folders)


def check_outputs(files: Iterable[Path]) -> None:
    """Find out before a long computation whether files can be written after it.

    It writes a few bytes to where each will be made, or its folder, and leaves nothing behind.
    """
    tried = set()
    for file in files:
        with naming(file):
            check_replaceable(file)
            place = existing_folder(file)
            if place not in tried:
                with stage_in(place):
                    tried.add(place)


def existing_folder(file: Path) -> Path:
    """The folder of a file, or that in which it will be made."""
    return next(folder for folder in file.parents if folder.exists())


def digests(folder: Path, names: Iterable[str] | None = None) -> dict[str, str]:
    """The SHA-256 of files by their paths in a folder; of all in it and those below it if none are named."""
    digest = {}
    for name in file_names_in(folder) if names is None else names:
        with (folder / name).open("rb") as file:
            digest[name] = hashlib.file_digest(file, "sha256").hexdigest()
    return digest


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Errors of the system inside are said of a path."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or " ".join(str(error).split())
        raise OutputError(f"{path}: cannot be written: {reason}") from None


@contextmanager
def stage_in(folder: Path) -> Iterator[Path]:
    """A new hidden folder in another, gone at the end; those of killed processes go first."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in os.listdir(folder):  # noqa: PTH208, as names alone are quick in a folder of many files
        if STAGE.fullmatch(name):
            remove_stale(folder / name)
    stage, lock = new_stage(folder)
    try:
        yield stage
    finally:
        lock.close()
        uninterrupted(lambda: shutil.rmtree(stage, ignore_errors=True))


def new_stage(folder: Path) -> tuple[Path, BinaryIO]:
    """A hidden folder, and the open file in it whose lock says that its process lives."""
    while True:
        stage = folder / f"{PREFIX}{secrets.token_hex(4)}"
        stage.mkdir()
        try:
            lock = (stage / LOCK).open("wb", buffering=0)
        except FileNotFoundError:  # another process came between, and took it for a killed one's
            continue
        try:
            lock.write(NOTE)
            if hold(lock) and os.fstat(lock.fileno()).st_nlink:
                return stage, lock
        except BaseException:
            lock.close()
            shutil.rmtree(stage, ignore_errors=True)
            raise
        lock.close()


def hold(lock: BinaryIO) -> bool:
    """Lock a file until it is closed or its process ends; False if another holds it."""
    if sys.platform != "win32":
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # a file system without locks, on which nothing counts as stale either
            pass
    return True


def remove_stale(stage: Path) -> None:
    """Remove a hidden folder unless its process lives, or nothing can tell, as on Windows."""
    if sys.platform != "win32":
        with suppress(OSError):
            try:
                with (stage / LOCK).open("r+b") as lock:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    shutil.rmtree(stage)
            except FileNotFoundError:
                stage.rmdir()


def uninterrupted(work: Callable[[], None]) -> None:
    """Do something that no signal may interrupt: neither one that ends the process nor the timer's.

    What came is raised again when the work is done. Python hears signals in the main thread only; others
    need no guard.
    """
    if threading.current_thread() is not threading.main_thread():
        work()
        return
    heard: list[int] = []
    kinds = [kind for kind in SIGNALS if signal.getsignal(kind) is not signal.SIG_IGN]
    before = {kind: signal.signal(kind, lambda number, _: heard.append(number)) for kind in kinds}
    try:
        work()
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler or signal.SIG_DFL)  # None where C code has set it
    if heard:
        signal.raise_signal(heard[0])


def file_names_in(folder: Path) -> list[str]:
    """Each file in a folder and those below it."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return sorted({path.relative_to(folder).as_posix() for path in paths} - {LOCK})


def move(stage: Path, folder: Path, last: str = "") -> None:
    """Let the files of a hidden folder take their places."""
    names = sorted(file_names_in(stage), key=lambda name: name == last)
    for name in names:
        with naming(folder / name):
            check_replaceable(folder / name)
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
    for name in names:
        with naming(folder / name):
            (stage / name).replace(folder / name)


def check_replaceable(path: Path) -> None:
    """Raise an error of the system if something stands at a path that no file can take the place of."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "Not a regular file")
    try:
        path.open("r+b").close()
    except PermissionError as error:  # EACCES alone does not matter: a new file comes, the old one goes
        if error.errno == errno.EPERM or sys.platform == "win32":
            raise
