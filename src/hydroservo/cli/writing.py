"""Writes what a command computed: where it was asked to, or else where it can be kept."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import typer

from hydroservo.outputs import OutputError, check_outputs, existing_folder, written_or_kept

MIB = 2**20  # bytes


class Written(NamedTuple):
    """What became of files.

    Attributes:
        files: those that took their places.
        failure: why others did not, and where they are instead; None if all did.
    """

    files: Sequence[Path] = ()
    failure: Exception | None = None

    def check(self) -> None:
        """Fail if something could not be written; to be called once all else is said."""
        if self.failure is not None:
            raise self.failure


def both(first: Written, second: Written) -> Written:
    """What became of two lots of files; of two failures, a defect goes before what could not be written."""
    failures = [one for one in (first.failure, second.failure) if one is not None]
    defects = [one for one in failures if not isinstance(one, OutputError)]
    lost = OutputError("; ".join(map(str, failures))) if failures else None
    return Written([*first.files, *second.files], defects[0] if defects else lost)


def try_outputs(files: Sequence[Path], size: int = 0) -> None:
    """Before a computation: find out whether its files can be written.

    Args:
        files: what will be written.
        size: about how much the largest of them will take [bytes]; a disk with less is warned of.

    Raises:
        OutputError: one cannot be written.
    """
    check_outputs(files)
    for folder in dict.fromkeys(existing_folder(file) for file in files):
        free = shutil.disk_usage(folder).free
        if free < size:
            said = f"{free / MIB:.3g} MiB are free, and about {size / MIB:.3g} MiB may be needed"
            typer.echo(f"hydroservo: warning: {folder}: {said}", err=True)


def write_or_keep(folder: Path | None, write: Callable[[Path], Sequence[Path]]) -> Written:
    """Write files into a folder, all or none; if none, into a temporary folder that the failure names.

    Args:
        folder: where they go; nothing is written if None.
        write: writes them into a folder and returns which they are.
    """
    try:
        return Written(() if folder is None else written_or_kept(folder, write))
    except OutputError as error:
        return Written((), error)
