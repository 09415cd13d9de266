"""The report as one page of HTML that refers to no other file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo._version import __version__
from hydroservo.reports.picture import address
from hydroservo.reports.templating import environment
from hydroservo.studies.report import tables
from hydroservo.studies.report.commands import Repeat
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.pictures import Picture
from hydroservo.studies.report.property_tables import property_rows
from hydroservo.studies.report.sentences import lead, sentences

if TYPE_CHECKING:
    import jinja2

__all__ = ["page"]


def page(
    found: Findings,
    drawn: Sequence[Picture],
    folder: Path,
    fingerprint: str,
    again: Mapping[tuple[str, str], Repeat],
) -> str:
    """The report's HTML.

    Args:
        found: what is reported.
        drawn: the pictures that it has.
        folder: holds them as SVG.
        fingerprint: names the results.
        again: by cell and law, a number and the command that repeats it.
    """
    standings = [one for cell in found.verdicts.cells.values() for one in cell.standings.values()]
    return template().render(
        manifest=found.manifest,
        reference=found.reference,
        made=found.manifest.get("hydroservo", __version__),
        judge=__version__,
        fingerprint=fingerprint,
        lead=lead(found),
        sentences=sentences(found),
        pictures=[(one, address(folder / f"{one.name}.svg")) for one in drawn],
        laws=tables.law_rows(found),
        cells=tables.cell_tables(found, again),
        properties=property_rows(found),
        rules=tables.rule_rows(found),
        metric=found.metric,
        axes=found.grid.axes,
        confidence=f"{100.0 * found.verdicts.rules.confidence:g} %",
        runs=sum(one.searches * one.conditions for one in standings),
    )


def template() -> "jinja2.Template":
    templates = environment("hydroservo.studies.report")
    return templates.get_template("report.html.j2")
