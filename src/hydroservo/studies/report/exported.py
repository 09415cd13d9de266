"""The report's tables as a spreadsheet and LaTeX take them: what each column is, and its rows."""

import math
from collections.abc import Iterator, Mapping, Sequence

from hydroservo.reports.table import Column, Table
from hydroservo.studies.report.captions import level_text
from hydroservo.studies.report.findings import Findings
from hydroservo.studies.report.property_tables import KINDS, property_rows
from hydroservo.studies.report.tables import CellTable, law_rows

Columns = Mapping[str, Column]  # by the key of their texts in a row

LAWS: Columns = {
    "law": Column("law"),
    "sensors": Column("sensors"),
    "gains": Column("gains", number=True),
    "ratio": Column("error, {confidence} interval", number=True),
    "best": Column("best", number=True),
    "tie": Column("ties", number=True),
    "behind": Column("behind", number=True),
    "out": Column("out", number=True),
    "cannot": Column("no gains", number=True),
    "lost": Column("lost runs", number=True),
    "activity": Column("command activity", number=True),
    "hunting": Column("hunting [%]", number=True),
    "margins": Column("max |S| [dB]", number=True),
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
    "hunting": Column("hunting [%]", number=True),
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
FRONTS: Columns = {
    "cell": Column("cell"),
    "law": Column("law"),
    "level": Column("level", number=True),
    "activity": Column("activity [%/s]", number=True),
    "error": Column("error [{unit}]", number=True),
    "error_low": Column("error low [{unit}]", number=True),
    "error_high": Column("error high [{unit}]", number=True),
    "ratio": Column("error over the reference's", number=True),
    "ratio_low": Column("ratio low", number=True),
    "ratio_high": Column("ratio high", number=True),
}
MARGINS = ("gain", "phase", "delay", "disk", "peak")  # which only a linear loop has


def with_headings(columns: Columns, **words: str) -> dict[str, Column]:
    """The columns with what their headings leave open.

    Args:
        columns: such as ``CELL``.
        words: ``confidence`` of intervals, ``unit`` of errors.
    """
    return {key: one._replace(heading=one.heading.format(**words)) for key, one in columns.items()}


def columns_of(cell: CellTable, confidence: str) -> dict[str, Column]:
    """The columns of a cell, with those of limits where they were sought."""
    columns = {**CELL, **LIMITS} if cell.rows[0]["limit"] else CELL
    return with_headings(columns, confidence=confidence, unit=cell.unit)


def confidence_of(found: Findings) -> str:
    """The confidence of all intervals, as a heading has it."""
    return f"{100.0 * found.verdicts.rules.confidence:g} %"


def law_columns(found: Findings) -> dict[str, Column]:
    """The columns of the table of laws: after the error, that of each kind of conditions."""
    kinds = found.manifest["kinds"]
    columns = with_headings(LAWS, confidence=confidence_of(found))
    if len(kinds) > 1:
        own = {f"kind-{k}": Column(str(kind), number=True) for k, kind in enumerate(kinds)}
        place = list(columns).index("ratio") + 1
        columns = dict([*list(columns.items())[:place], *own.items(), *list(columns.items())[place:]])
    return columns


def exported(found: Findings, cells: Sequence[CellTable]) -> Iterator[Table]:
    """At each level the table of laws over all cells; of each cell its laws, and their properties if known.

    Args:
        found: what is reported.
        cells: the tables of the page.
    """
    confidence = confidence_of(found)
    yield front_table(found)
    for level in found.verdicts.levels:
        own = found._replace(level=level)
        about = f"Each law over all cells, {level_text(own)}."
        about = f"{about} Errors are over those of {found.reference} at its own activity."
        yield table(f"laws-{level}", law_columns(found), law_rows(own), about)
    properties = property_rows(found)
    for cell in cells:
        best = frozenset((i, 0) for i, row in enumerate(cell.rows) if row["class"] == "best")
        one = table(
            f"cell-{cell.name}", columns_of(cell, confidence), cell.rows, f"{cell.where}. {cell.best}."
        )
        yield one._replace(marked=best)
        if own_rows := properties.get(cell.name):
            laws = [row["law"] for row in cell.rows if row["law"] in own_rows]
            rows = [{"law": law, **plain(own_rows[law])} for law in laws]
            yield table(f"properties-{cell.name}", PROPERTIES, rows, f"{cell.where}. Margins and price.")


def front_table(found: Findings) -> Table:
    """Each point of each front, in SI units but for the activity."""
    numbers = list(FRONTS)[3:]
    rows = [
        {
            "cell": cell,
            "law": law,
            "level": "" if math.isnan(one.level) else f"{one.level:g}",
            **{key: f"{value:.5g}" for key, value in zip(numbers, (*one[:4], *one.ratio), strict=True)},
        }
        for cell, own in found.verdicts.fronts.items()
        for law, (points, _) in own.items()
        for one in points
    ]
    about = "The fronts of all laws on test conditions. Level: the smallest at which these gains are taken."
    return table("fronts", with_headings(FRONTS, unit=found.unit), rows, about)


def plain(row: Mapping[str, str]) -> dict[str, str]:
    """A row of properties in which each text has one column."""
    if row["kind"] == "linear":
        return dict(row)
    return {**row, **dict.fromkeys(MARGINS, KINDS[row["kind"]])}


def table(name: str, columns: Columns, rows: Sequence[Mapping[str, str]], title: str) -> Table:
    """Rows by key as rows by place."""
    return Table(name, [*columns.values()], [[row[key] for key in columns] for row in rows], title)
