"""Findings, tables and lines as HTML, as notebooks show them: everything escaped, no colour of their own."""

from collections.abc import Sequence
from html import escape
from itertools import zip_longest

from hydroservo.show.finding import Finding, Line
from hydroservo.show.table import Mark, Table, note_of, texts_of

STYLE = 'style="text-align: {}; padding-right: 1em"'  # notebooks end all cells at the right
WRONG = (Mark.BAD, Mark.DOUBTFUL)


def html_of(finding: Finding) -> str:
    """A finding as a notebook shows it: its title, its lines, its tables and its remarks."""
    several = len(finding.filled) > 1
    return "".join(
        [
            f"<div><b>{escape(finding.title)}</b></div>",
            *map(html_line, finding.lead),
            *(html_table(table, titled=several) for table in finding.filled),
            *(f"<div><b>{escape(remark)}</b></div>" for remark in finding.remarks),
        ]
    )


def html_line(line: Line) -> str:
    """A line as a paragraph, its lead bold where that stands out."""
    lead = f"<b>{escape(line.lead)}</b>" if line.mark in WRONG else escape(line.lead)
    command = f" <code>{escape(line.command)}</code>" if line.command else ""
    return f"<div>{lead}{escape(line.rest)}{command}</div>"


def html_table(table: Table, *, titled: bool = True) -> str:
    """A table with its headings: what is best bold, what is bad or doubtful in italics."""
    texts = texts_of(table)
    rows = [
        html_row(row, [cell.mark for cell in cells], texts.right)
        for row, cells in zip(texts.rows, table.rows, strict=True)
    ]
    title = f"<div>{escape(table.title)}</div>" if titled and table.title else ""
    note = note_of(table, "Bold:")
    beneath = f"<div><small>{escape(note)}</small></div>" if note else ""
    heads = html_row(texts.headings, right=texts.right, tag="th")
    return f"{title}<table>{heads}{''.join(rows)}</table>{beneath}"


def html_row(
    texts: Sequence[str],
    marks: Sequence[Mark | None] = (),
    right: Sequence[bool] = (),
    *,
    tag: str = "td",
    span: int = 1,
) -> str:
    wide = f' colspan="{span}"' if span > 1 else ""
    cells = zip_longest(texts, marks, right)
    return f"<tr>{''.join(html_cell(*cell, tag, wide) for cell in cells)}</tr>"


def html_cell(text: str, mark: Mark | None, right: bool | None, tag: str, wide: str) -> str:
    style = STYLE.format("right" if right else "left")
    shape = "b" if mark is Mark.BEST else "i" if mark in WRONG else ""
    content = f"<{shape}>{escape(text)}</{shape}>" if shape else escape(text)
    return f"<{tag}{wide} {style}>{content}</{tag}>"
