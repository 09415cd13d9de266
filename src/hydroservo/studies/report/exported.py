"""The report's tables as a spreadsheet and LaTeX take them: what each column is, and its rows."""

from collections.abc import Iterator, Mapping, Sequence

from hydroservo.reports.table import Column, Table
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.property_tables import KINDS, property_rows
from hydroservo.studies.report.tables import CellTable, law_rows

__all__ = ["CELL", "LAWS", "LIMITS", "PROPERTIES", "columns_of", "confidence_of", "exported", "headed"]

Columns = Mapping[str, Column]  # by the key of their texts in a row

LAWS: Columns = {
    "law": Column("law"),
    "sensors": Column("sensors"),
    "gains": Column("gains", number=True),
    "near": Column("near best", number=True),
    "out": Column("out", number=True),
    "largest": Column("largest regret", number=True),
    "ratio": Column("error, {confidence} interval", number=True),
    "lost": Column("lost runs", number=True),
    "activity": Column("command activity", number=True),
    "operations": Column("operations", number=True),
    "bytes": Column("bytes", number=True),
}
CELL: Columns = {
    "law": Column("law"),
    "verdict": Column("verdict"),
    "error": Column("error [{unit}]", number=True),
    "ratio": Column("over best, {confidence} alone", number=True),
    "chance": Column("Holm's chance", number=True),
    "tail": Column("tail [{unit}]", number=True),
    "lost": Column("lost runs [%]", number=True),
    "activity": Column("activity [%/s]", number=True),
    "survived": Column("survives", number=True),
    "rank": Column("rank"),
}
LIMITS: Columns = {
    "limit": Column("over clairvoyant limit", number=True),
    "causal": Column("over causal limit", number=True),
}
PROPERTIES: Columns = {
    "law": Column("law"),
    "points": Column("linear points", number=True),
    "gain": Column("gain margin", number=True),
    "phase": Column("phase margin [°]", number=True),
    "delay": Column("delay margin [ms]", number=True),
    "disk": Column("disk margin", number=True),
    "peak": Column("max |S|", number=True),
    "operations": Column("operations", number=True),
    "divisions": Column("divisions", number=True),
    "roots": Column("roots", number=True),
    "functions": Column("functions", number=True),
    "state": Column("state [B]", number=True),
    "parameters": Column("parameters [B]", number=True),
}
MARGINS = ("gain", "phase", "delay", "disk", "peak")  # which only a linear loop has


def headed(columns: Columns, **said: str) -> dict[str, Column]:
    """The columns with what their headings leave open.

    Args:
        columns: such as ``CELL``.
        said: ``confidence`` of intervals, ``unit`` of errors.
    """
    return {key: one._replace(heading=one.heading.format(**said)) for key, one in columns.items()}


def columns_of(cell: CellTable, confidence: str) -> dict[str, Column]:
    """The columns of a cell, with those of limits where they were sought."""
    columns = {**CELL, **LIMITS} if cell.rows[0]["limit"] else CELL
    return headed(columns, confidence=confidence, unit=cell.unit)


def confidence_of(found: Findings) -> str:
    """The confidence of all intervals, as a heading has it."""
    return f"{100.0 * found.verdicts.rules.confidence:g} %"


def exported(found: Findings, cells: Sequence[CellTable]) -> Iterator[Table]:
    """The table of laws over all cells; of each cell its laws, and where they are known their properties.

    Args:
        found: what is reported.
        cells: the tables of the page.
    """
    confidence = confidence_of(found)
    about = f"Each law over all cells. Errors and activity are over those of {found.reference}."
    yield table("laws", headed(LAWS, confidence=confidence), law_rows(found), about)
    properties = property_rows(found)
    for cell in cells:
        best = frozenset((i, 0) for i, row in enumerate(cell.rows) if row["class"] == "best")
        one = table(
            f"cell-{cell.name}", columns_of(cell, confidence), cell.rows, f"{cell.where}. {cell.best}."
        )
        yield one._replace(marked=best)
        if own := properties.get(cell.name):
            rows = [{"law": row["law"], **plain(own[row["law"]])} for row in cell.rows if row["law"] in own]
            yield table(f"properties-{cell.name}", PROPERTIES, rows, f"{cell.where}. Margins and price.")


def plain(row: Mapping[str, str]) -> dict[str, str]:
    """A row of properties in which each text has one column."""
    if row["kind"] == "linear":
        return dict(row)
    return {**row, **dict.fromkeys(MARGINS, KINDS[row["kind"]])}


def table(name: str, columns: Columns, rows: Sequence[Mapping[str, str]], title: str) -> Table:
    """Rows by key as rows by place."""
    return Table(name, [*columns.values()], [[row[key] for key in columns] for row in rows], title)
