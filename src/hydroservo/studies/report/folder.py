"""The report on a study: a folder with its pictures and one page that opens offline."""

import hashlib
import json
from collections.abc import Callable, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo._version import __version__
from hydroservo.outputs import staged, write_text
from hydroservo.show.journal import NO_JOURNAL, Journal, with_decimal_commas
from hydroservo.show.numbers import METRICS, as_json, write_metrics
from hydroservo.show.page import FIGURES, address, write_figure, write_tables
from hydroservo.studies.report.cell_tables import cell_tables
from hydroservo.studies.report.commands import conditions_in, repeats
from hydroservo.studies.report.findings import findings
from hydroservo.studies.report.law_tables import law_tables
from hydroservo.studies.report.page import page
from hydroservo.studies.report.pictures import pictures
from hydroservo.studies.report.tables import front_table
from hydroservo.studies.verdicts import Verdicts

if TYPE_CHECKING:
    import pandas as pd

REPORT = "report.html"
VERDICTS = "verdicts.json"
PICTURES = "pictures"
VERSIONS = ("format", "hydroservo")  # what a store adds to a manifest
Progress = Callable[[int, int], None]  # done, of how many


def write_report(
    table: "pd.DataFrame",
    manifest: Mapping[str, Any],
    verdicts: Verdicts,
    folder: Path,
    *,
    progress: Progress | None = None,
    journal: Journal = NO_JOURNAL,
    command: str = "",
) -> Path:
    """Write a study's pictures and its report into its folder.

    The folder then holds ``report.html``, ``verdicts.json``, each picture as PNG and SVG in ``pictures``,
    each table as CSV and LaTeX in ``tables``, for a journal each picture in ``figures``, and ``metrics.json``
    with the SHA-256 of all these. They take their places together, and equal studies give equal bytes.

    Args:
        table: the study's: a row a run.
        manifest: what ``study.json`` holds.
        verdicts: what :func:`~hydroservo.studies.verdicts.judged` found.
        folder: the study's; numbers whose conditions it has get the command that repeats them.
        progress: called after each picture.
        journal: what figures a journal is to have.
        command: makes the study again.

    Returns:
        The path of ``report.html``.
    """
    found = findings(manifest, verdicts)
    asked = {key: value for key, value in manifest.items() if key not in VERSIONS}
    fingerprint = digest({"manifest": asked, "verdicts": verdicts.as_dict()})
    drawn = pictures(found)
    again = repeats(table, found, conditions_in(folder))
    levels = {level: law_tables(found._replace(level=level)) for level in verdicts.levels}
    cells = {name: cell_tables(found, name) for name in manifest["cells"] if name in found.at.cells}
    with staged(folder, last=METRICS) as stage:
        for done, one in enumerate(drawn, start=1):
            figure = one.draw()
            write_figure(figure, stage / PICTURES / one.name, fingerprint)
            journal.save(figure, stage / FIGURES / one.name, fingerprint)
            if progress:
                progress(done, len(drawn))
        write_text(stage / VERDICTS, as_json(verdicts.as_dict()) + "\n")
        write_tables(stage, [front_table(found), *chain(*levels.values(), *cells.values())])
        if journal.decimal_comma:
            with_decimal_commas(stage)
        addresses = [(one, address(stage / PICTURES / f"{one.name}.svg")) for one in drawn]
        write_text(stage / REPORT, page(found, addresses, fingerprint, levels, cells, again, command))
        about = {"title": manifest["title"], "fingerprint": fingerprint, "version": __version__}
        write_metrics(stage, about)
    return folder / REPORT


def report_files(folder: Path) -> list[Path]:
    """What :func:`write_report` writes beside pictures and tables."""
    return [folder / name for name in (VERDICTS, REPORT, METRICS)]


def digest(content: Mapping[str, Any]) -> str:
    """The first digits of the SHA-256 of what was asked and found."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:12]
