"""The report as one page of HTML that refers to no other file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hydroservo._version import __version__
from hydroservo.reports.picture import address
from hydroservo.reports.templating import environment
from hydroservo.studies.report import tables
from hydroservo.studies.report.captions import level_text
from hydroservo.studies.report.exported import PROPERTIES, columns_of, confidence_of, law_columns
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.pictures import Picture
from hydroservo.studies.report.property_tables import KINDS, property_rows
from hydroservo.studies.report.sentences import lead, sentences
from hydroservo.studies.report.tables import CellTable

if TYPE_CHECKING:
    import jinja2


def page(
    found: Findings,
    drawn: Sequence[Picture],
    folder: Path,
    fingerprint: str,
    cells: Sequence[CellTable],
    command: str,
) -> str:
    """The report's HTML.

    Args:
        found: what is reported.
        drawn: the pictures that it has.
        folder: holds them as SVG.
        fingerprint: names the results.
        cells: the tables of its cells.
        command: makes the study again; empty where it is not known.
    """
    confidence = confidence_of(found)
    levels = [found._replace(level=level) for level in found.verdicts.levels]
    return template().render(
        manifest=found.manifest,
        reference=found.reference,
        made=found.manifest.get("hydroservo", __version__),
        judge=__version__,
        fingerprint=fingerprint,
        lead=lead(found),
        sentences=sentences(found),
        pictures=[(one, address(folder / f"{one.name}.svg")) for one in drawn],
        levels=[(level_text(one), tables.law_rows(one)) for one in levels],
        shown=level_text(found),
        law_columns=law_columns(found),
        cells=cells,
        cell_columns={one.name: columns_of(one, confidence) for one in cells},
        property_columns=PROPERTIES,
        kinds=KINDS,
        command=command,
        properties=property_rows(found),
        rules=tables.rule_rows(found),
        metric=found.metric,
        axes=found.grid.axes,
        confidence=confidence,
    )


def template() -> "jinja2.Template":
    templates = environment("hydroservo.studies.report")
    return templates.get_template("report.html.j2")
