"""The files of a report: a page that opens offline, its pictures, its tables, and figures for a journal."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hydroservo._version import __version__
from hydroservo.outputs import write_text
from hydroservo.reports.journal import NO_JOURNAL, Journal
from hydroservo.reports.latex import latex_text
from hydroservo.reports.picture import address
from hydroservo.reports.report import Picture, Report
from hydroservo.reports.table import Table, csv_text
from hydroservo.reports.templating import environment

REPORT = "report.html"
TABLES = "tables"
FIGURES = "figures"


class Files(NamedTuple):
    """What a report will have, as far as it is known before anything is computed.

    Attributes:
        pictures: their names.
        tables: their names.
        journal: what figures a journal is to have.
    """

    pictures: Sequence[str]
    tables: Sequence[str]
    journal: Journal = NO_JOURNAL

    def names(self) -> list[str]:
        """The files of the report by their paths in its folder."""
        return [
            *(f"{name}{ending}" for name in self.pictures for ending in (".png", ".svg")),
            *(f"{FIGURES}/{name}.{form}" for name in self.pictures for form in self.journal.formats),
            *(f"{TABLES}/{name}{ending}" for name in self.tables for ending in (".csv", ".tex")),
            REPORT,
        ]


def write_report(stage: Path, report: Report, journal: Journal = NO_JOURNAL) -> Files:
    """Write a report into a folder; equal reports give equal bytes.

    It has the page ``report.html``, which holds its pictures; each picture as PNG and SVG, and for a journal
    in ``figures``; and each table as CSV and LaTeX in ``tables``.

    Args:
        stage: a folder, such as :func:`~hydroservo.outputs.staged` gives.
        report: what it says.
        journal: what figures a journal is to have.

    Returns:
        What was written.

    Raises:
        HydroservoError: a file cannot be written.
    """
    from hydroservo.figures.style import save_figure

    origin = " ".join(one.hash for one in report.origins) or report.title
    for one in report.pictures:
        save_figure(one.figure, stage / one.name, origin)
    shown = [Shown(one, address(stage / f"{one.name}.svg"), share(one)) for one in report.pictures]
    for one in report.pictures:
        journal.save(one.figure, stage / FIGURES / one.name, origin)
    write_tables(stage, report.tables)
    template = environment("hydroservo.reports").get_template("report.html.j2")
    write_text(stage / REPORT, template.render(report=report, pictures=shown, version=__version__))
    return Files([one.name for one in report.pictures], [one.name for one in report.tables], journal)


class Shown(NamedTuple):
    """A picture on the page.

    Attributes:
        picture: what is shown.
        source: its content, as an address that needs no file.
        share: of the widest picture's width.
    """

    picture: Picture
    source: str
    share: float


def share(picture: Picture) -> float:
    """How wide a picture is beside one as wide as the text, so that its letters are as large."""
    from hydroservo.figures.style import WIDTH

    return min(float(picture.figure.get_figwidth()) / WIDTH, 1.0)


def write_tables(stage: Path, tables: Sequence[Table]) -> None:
    """Write each table as CSV and LaTeX into the folder ``tables`` of another."""
    for table in tables:
        write_text(stage / TABLES / f"{table.name}.csv", csv_text(table))
        write_text(stage / TABLES / f"{table.name}.tex", latex_text(table))
