"""The folder that a command leaves: its own files, its report, and its numbers with digests of them all."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from hydroservo.runs.results import METRICS

if TYPE_CHECKING:
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import Journal
    from hydroservo.reports.report import Report

__all__ = [
    "PICTURE_ENDINGS",
    "OwnFiles",
    "file_or_folder",
    "is_folder",
    "list_files",
    "result_files",
    "write_results",
]

OwnFiles = Mapping[str, Callable[[Path], object]]  # files besides the report, by name, and what writes each

PICTURE_ENDINGS = (".png", ".svg", ".pdf")


def is_folder(text: str, endings: Sequence[str] = ()) -> bool:
    """Whether ``--out`` means a folder where it may mean a file: there is one, or it ends in a slash.

    Args:
        text: as it was typed.
        endings: of what is a file all the same.
    """
    path = Path(text)
    return text.endswith(("/", os.sep)) or (path.suffix.lower() not in endings and path.is_dir())


def file_or_folder(text: str | None) -> tuple[Path | None, Path | None]:
    """The file that ``--out`` names, or else the folder; nothing where it was not given."""
    if text is None:
        return None, None
    return (None, Path(text)) if is_folder(text) else (Path(text), None)


def result_files(folder: Path, own: Iterable[str], report: "Files") -> list[Path]:
    """What :func:`write_results` writes."""
    return [folder / name for name in (*own, METRICS, *report.names())]


def write_results(
    folder: Path, own: OwnFiles, report: "Report", said: Mapping[str, Any], journal: "Journal"
) -> list[Path]:
    """Write what a command found into a folder, together.

    Args:
        folder: missing ones are made.
        own: the files besides the report.
        report: its pictures, its tables and its page.
        said: all numbers, as ``--json`` prints them, for ``metrics.json``.
        journal: what figures a journal is to have, and what decimals tables have.

    Returns:
        What was written.

    Raises:
        HydroservoError: a file cannot be written.
    """
    from hydroservo.outputs import staged
    from hydroservo.reports.decimal_commas import with_decimal_commas
    from hydroservo.reports.folder import write_report
    from hydroservo.runs.results import write_metrics

    with staged(folder, last=METRICS) as stage:
        for name, write in own.items():
            write(stage / name)
        files = write_report(stage, report, journal)
        if journal.decimal_comma:
            with_decimal_commas(stage)
        write_metrics(stage, said)
    return result_files(folder, own, files)


def list_files(files: Sequence[Path]) -> None:
    """Say on the terminal which files a folder got; those of tables and figures as folders."""
    if files:
        typer.echo(f"written to {files[0].parent}: {', '.join(names_below(files[0].parent, files))}")


def names_below(folder: Path, files: Sequence[Path]) -> list[str]:
    """Files by their names in a folder, with the folders between; those of tables and figures as folders."""
    below = (file.relative_to(folder) for file in files)
    return list(dict.fromkeys(one.name if one.parent == Path() else f"{one.parts[0]}/" for one in below))
