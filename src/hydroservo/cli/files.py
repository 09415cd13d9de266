"""The folder that a command leaves: its own files, its report, and its numbers with digests of them all."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from hydroservo.runs.results import METRICS

if TYPE_CHECKING:
    from hydroservo.reports.folder import Files
    from hydroservo.reports.journal import Journal
    from hydroservo.reports.report import Report

OwnFiles = Mapping[str, Callable[[Path], object]]  # files besides the report, by name, and what writes each

PICTURE_ENDINGS = (".png", ".svg", ".pdf")


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
