"""Runs commands where there is no room, no right to write, or no home, and looks at what they say and leave.

The disks are in memory, of some pages each, and mounted for the count, which needs root. Full or read-only,
they stop root as they stop any user; another user's folder does not, so there the command runs as nobody.
"""

import os
import random
import shutil
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tools.promises.commands import COMMANDS
from tools.promises.forked import start, warm_up
from tools.promises.left import files_in
from tools.promises.trials import Trial, broken, set_up

NOBODY = 65534
PAGE = 4096  # bytes
ROOM = 4096  # pages of a disk that is not to be full
WITHOUT_HOME = ("HOME", "XDG_CACHE_HOME", "HYDROSERVO_CACHE_DIR")
COUNTED = ("attempts", "broken", "one line", "ended well")

Say = Callable[[str], None]
Draw = random.Random
Prepare = Callable[[], Any]


def count_places(count: int, seed: int, say: Say = print) -> list[dict[str, Any]]:
    """Do ``count`` commands, as many in each kind of place; a row for each.

    Raises:
        PermissionError: it is not root who counts.
        RuntimeError: a command fails where nothing is wrong.
    """
    if os.getuid() != 0:
        raise PermissionError("only root can mount what is full")
    warm_up()
    tallies = {name: Counter[str]() for name in WHERE}
    commands = {name: one for name, one in COMMANDS.items() if name not in ("study", "paper")}
    with tempfile.TemporaryDirectory(prefix="places-") as folder:
        Path(folder).chmod(0o755)
        for name, one in commands.items():
            trial = set_up(one, Path(folder) / name, Draw(f"{seed} {name}"))
            for i in range(-(-count // (len(commands) * len(WHERE)))):
                for where, arranged in WHERE.items():
                    problems, status = tried(trial, arranged, i)
                    tally = tallies[where]
                    tally["attempts"] += 1
                    tally["broken"] += bool(problems)
                    tally["one line" if status else "ended well"] += 1
                    for problem in problems:
                        say(f"{name}, {where}: {problem}")
    return [{"place": where, **{key: tally[key] for key in COUNTED}} for where, tally in tallies.items()]


def tried(trial: Trial, arranged: Any, i: int) -> tuple[list[str], int]:
    """How a command broke the promise in a place, and its exit status."""
    variant = i % len(trial.wanted)
    shutil.rmtree(trial.folders.out, ignore_errors=True)
    with arranged(trial) as (prepare, may_fail):
        before = files_in(trial.folders.out)
        said = trial.folders.out.parent / "said"

        def prepared() -> None:
            trial.prepare()
            prepare()

        ended = start(trial.words(variant), said, prepared).ended()
        problems = broken(trial, variant, before, ended, [])
    if ended.status and not may_fail:
        problems.append(f"it failed: {ended.err[-300:]}")
    return problems, ended.status


@contextmanager
def disk(trial: Trial, pages: int) -> Iterator[None]:
    """The command's own folder as a disk of so many pages."""
    trial.folders.out.mkdir()
    options = f"size={pages * PAGE}"
    by_root("mount", "-t", "tmpfs", "-o", options, "hydroservo", str(trial.folders.out))
    try:
        yield
    finally:
        by_root("umount", str(trial.folders.out))


@contextmanager
def full(trial: Trial) -> Iterator[tuple[Prepare, bool]]:
    """A disk with some pages fewer than the files take twice, as many as are drawn."""
    with disk(trial, pages_of(trial)):
        yield (lambda: None), True


@contextmanager
def full_altogether(trial: Trial) -> Iterator[tuple[Prepare, bool]]:
    """The same, and the temporary folder is on it."""
    with disk(trial, pages_of(trial)):

        def prepare() -> None:
            os.environ["TMPDIR"] = str(trial.folders.out)
            tempfile.tempdir = None

        yield prepare, True


def pages_of(trial: Trial) -> int:
    """A number of pages, of which some are enough."""
    return trial.draw.randrange(2, 3 * max(len(wanted) for wanted in trial.wanted) + 24)


@contextmanager
def read_only(trial: Trial) -> Iterator[tuple[Prepare, bool]]:
    """A disk with the files of an earlier command that is only read."""
    with disk(trial, ROOM):
        ended = start(trial.words(0), trial.folders.out.parent / "said", trial.prepare).ended()
        if ended.status:
            raise RuntimeError(ended.err)
        by_root("mount", "-o", "remount,ro", str(trial.folders.out))
        yield (lambda: None), True


@contextmanager
def no_right(trial: Trial) -> Iterator[tuple[Prepare, bool]]:
    """Another user's folder."""
    trial.folders.out.mkdir(mode=0o755)
    trial.folders.temporary.chmod(0o777)
    yield as_nobody, True


@contextmanager
def no_home(trial: Trial) -> Iterator[tuple[Prepare, bool]]:
    """A user who has no home, and may write into the folder."""
    trial.folders.out.mkdir(mode=0o755)
    trial.folders.temporary.chmod(0o777)
    os.chown(trial.folders.out, NOBODY, NOBODY)

    def prepare() -> None:
        as_nobody()
        for name in WITHOUT_HOME:
            os.environ.pop(name, None)

    yield prepare, False


def by_root(*words: str) -> None:
    subprocess.run(words, check=True)


def as_nobody() -> None:
    """Be a user without rights."""
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)


WHERE = {
    "a full disk": full,
    "a full disk, with the temporary folder": full_altogether,
    "a read-only disk": read_only,
    "another user's folder": no_right,
    "no home": no_home,
}
