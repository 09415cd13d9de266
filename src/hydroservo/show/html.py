"""Findings, tables and lines as HTML, as notebooks show them: everything escaped, no colour of their own."""

from collections.abc import Sequence
from html import escape

from hydroservo.show.finding import Finding, Line
from hydroservo.show.table import Mark, Table, texts_of

LEFT = 'style="text-align: left; padding-right: 1em"'  # and not as notebooks have it
STRONG = (Mark.BEST, Mark.BAD, Mark.DOUBTFUL)


class Strong(str):
    """A text of a cell that stands out."""

    __slots__ = ()


def html_of(finding: Finding) -> str:
    """A finding as a notebook shows it: its title, its lines, its tables and its remarks."""
    several = len(finding.tables) > 1
    return "".join(
        [
            f"<div><b>{escape(finding.title)}</b></div>",
            *map(html_line, finding.lead),
            *(html_table(table, titled=several) for table in finding.tables),
            *(f"<div><b>{escape(remark)}</b></div>" for remark in finding.remarks),
        ]
    )


def html_line(line: Line) -> str:
    """A line as a paragraph, its lead bold where that stands out."""
    lead = Strong(line.lead) if line.mark in STRONG else line.lead
    command = f" <code>{escape(line.command)}</code>" if line.command else ""
    return f"<div>{cell_text(lead)}{escape(line.rest)}{command}</div>"


def html_table(table: Table, *, titled: bool = True) -> str:
    """A table with its headings; empty where there is no row."""
    if not table.rows:
        return ""
    texts = texts_of(table)
    rows = [
        [Strong(text) if cell.mark in STRONG else text for text, cell in zip(*pair, strict=True)]
        for pair in zip(texts.rows, table.rows, strict=True)
    ]
    title = f"<div>{escape(table.title)}</div>" if titled and table.title else ""
    about = " ".join(filter(None, ["Bold: the best" if texts.best else "", table.note]))
    note = f"<div><small>{escape(about)}</small></div>" if about else ""
    body = "".join([html_row(texts.headings, "th"), *map(html_row, rows)])
    return f"{title}<table>{body}</table>{note}"


def html_row(texts: Sequence[str], tag: str = "td", span: int = 1) -> str:
    """A row of a table.

    Args:
        texts: of its cells; a :class:`Strong` one is bold.
        tag: th for heads.
        span: over how many columns each goes.
    """
    wide = f' colspan="{span}"' if span > 1 else ""
    return f"<tr>{''.join(f'<{tag}{wide} {LEFT}>{cell_text(text)}</{tag}>' for text in texts)}</tr>"


def cell_text(text: str) -> str:
    return f"<b>{escape(text)}</b>" if isinstance(text, Strong) else escape(text)
