"""Commands that are tried where something fails, and what is wrong with how they end."""

import os
import random
import re
import shutil
import tempfile
from pathlib import Path
from typing import NamedTuple

from hydroservo.core.outputs import PREFIX
from tools.promises.commands import Command
from tools.promises.forked import Ended, start
from tools.promises.left import Files, damage, files_in, hidden

TO_STDERR = re.compile(r"\bwrite\(2<")
TO_REMOVE = re.compile(rf'unlink|rmdir|{re.escape(PREFIX)}\w+", O_RDONLY')
KEPT = re.compile(r"kept in (.+) instead")
UNITS = re.compile(r"[\d,]+ of [\d,]+ units failed, such as ")
ASIDE = re.compile(r"hydroservo: (warning: |\d+ % done|.+ is damaged, and done again)")
SEVERAL = 0.5  # a command of a lesser share takes long, and has one variant


class Folders(NamedTuple):
    """Folders of a command: its own, the temporary one, and that of kernels."""

    out: Path
    temporary: Path
    cache: Path


class Trial(NamedTuple):
    """A command in its folders, what each variant leaves, and from what is drawn."""

    command: Command
    folders: Folders
    wanted: list[Files]
    draw: random.Random

    def words(self, variant: int) -> list[str]:
        """What a variant is called with."""
        return self.command.words(self.folders.out, variant)

    def prepare(self) -> None:
        """What its process does first."""
        temporary, cache = str(self.folders.temporary), str(self.folders.cache)
        os.environ |= {"TMPDIR": temporary, "HYDROSERVO_CACHE_DIR": cache}
        tempfile.tempdir = None
        self.command.prepare()


def set_up(command: Command, folder: Path, draw: random.Random) -> Trial:
    """Folders for a command that has run there in each variant.

    Raises:
        RuntimeError: it fails.
    """
    folders = Folders(folder / "out", folder / "temporary", folder / "cache")
    folders.temporary.mkdir(parents=True)
    command.warm()
    trial = Trial(command, folders, [], draw)
    for variant in range(1 if command.goes_on or command.share < SEVERAL else 2):
        shutil.rmtree(folders.out, ignore_errors=True)
        ended = start(trial.words(variant), folder, trial.prepare).ended()
        if ended.status:
            raise RuntimeError(ended.err)
        trial.wanted.append(files_in(folders.out))
    return trial


def broken(trial: Trial, variant: int, before: Files, ended: Ended, failed: list[str]) -> list[str]:
    """How a command broke the promise.

    Args:
        trial: the command.
        variant: the number of its variant.
        before: what was in its folder.
        ended: how it ended.
        failed: the calls that did, as strace says them; what could not be removed may stay.
    """
    folders, wanted, after = trial.folders, trial.wanted[variant], files_in(trial.folders.out)
    stays = any(map(TO_REMOVE.search, failed))
    unheard = any(TO_STDERR.search(call) for call in failed)
    problems = damage(before, after, wanted, trial.command.last)
    if ended.status == 0 and {name: after[name] for name in after.keys() - hidden(after)} != wanted:
        problems.append("it ended well and left other files than it should")
    if not stays and hidden(after) - (hidden(before) if failed else set()):
        problems.append("it left hidden files")
    if ended.status not in (0, 2):
        problems.append(f"it ended with {ended.status}: {ended.err[-600:]}")
    elif not unheard and not is_one_line(ended):
        problems.append(f"it ended with {ended.status} and said {ended.err!r}")
    problems += [f"what it kept in {folder} is not whole" for folder in kept_half(ended, wanted)]
    if remove_all(folders.temporary) and not stays:
        problems.append("it left something else in the temporary folder")
    return problems


def is_one_line(ended: Ended) -> bool:
    """Whether a command that failed said why in one line.

    Warnings, progress and parts that are done again do not count, nor what is said of units of work before a
    line says how many failed.
    """
    said = [line for line in ended.err.splitlines() if not ASIDE.match(line)]
    if said and UNITS.search(said[-1]):
        said = said[-1:]
    return len(said) == bool(ended.status) and all(line.startswith("hydroservo: ") for line in said)


def kept_half(ended: Ended, wanted: Files) -> list[str]:
    """The folders in which a command says that it kept files, and did not whole; all are removed."""
    found = []
    for said in KEPT.finditer(ended.err):
        kept = files_in(Path(said[1]))
        if not kept or not kept.items() <= wanted.items():
            found.append(said[1])
        shutil.rmtree(said[1], ignore_errors=True)
    return found


def remove_all(folder: Path) -> bool:
    """Empty a folder; whether something was in it."""
    left = list(folder.iterdir())
    for path in left:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    return bool(left)
