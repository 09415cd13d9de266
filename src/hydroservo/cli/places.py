"""What ``--out`` means, in all commands."""

import os
from collections.abc import Sequence
from pathlib import Path

import typer

WHERE = "A name with an ending is a file; one without, or with a / at its end, is a folder."


def is_folder(text: str, endings: Sequence[str] = ()) -> bool:
    """Whether a name means a folder: it has no ending, or a slash at its end, or there is such a folder.

    Args:
        text: as it was typed.
        endings: of what is a file all the same.
    """
    path = Path(text)
    ending = path.suffix.lower()
    return text.endswith(("/", os.sep)) or not ending or (ending not in endings and path.is_dir())


def folder_at(text: str | Path) -> Path:
    """The folder that ``--out`` of a command names that leaves several files.

    Raises:
        BadParameter: it means a file, or there is one.
    """
    path, typed = Path(text), os.fspath(text)
    if not is_folder(typed):
        raise typer.BadParameter(f"{typed!r} is a file, by its ending; for a folder write {f'{typed}/'!r}")
    if path.exists() and not path.is_dir():
        raise typer.BadParameter(f"{typed!r} is a file, and this command writes into a folder")
    return path


def file_at(text: str | Path) -> Path:
    """The file that ``--out`` of a command names that leaves one.

    Raises:
        BadParameter: it means a folder.
    """
    typed = os.fspath(text)
    if is_folder(typed):
        raise typer.BadParameter(f"{typed!r} is a folder, and this command writes a file, with an ending")
    return Path(text)
