"""Tables and remarks as HTML, as notebooks show them: everything escaped, and no colour of their own."""

from collections.abc import Iterable, Sequence
from html import escape

LEFT = 'style="text-align: left; padding-right: 1em"'  # and not as notebooks have it


class Strong(str):
    """A text of a cell that stands out."""

    __slots__ = ()


def html_heading(title: str, about: str = "") -> str:
    """A line above a table: a title, and what it is of in smaller letters."""
    small = f" <small>{escape(about)}</small>" if about else ""
    return f"<div><b>{escape(title)}</b>{small}</div>"


def html_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with its column heads; empty where there is no row.

    Args:
        heads: of the columns.
        rows: the texts of each row's cells; a :class:`Strong` one is bold.
    """
    body = "".join(map(html_row, rows))
    return f"<table>{html_row(heads, 'th')}{body}</table>" if body else ""


def html_row(texts: Sequence[str], tag: str = "td", span: int = 1) -> str:
    """A row of a table.

    Args:
        texts: of its cells.
        tag: th for heads.
        span: over how many columns each goes.
    """
    wide = f' colspan="{span}"' if span > 1 else ""
    return f"<tr>{''.join(f'<{tag}{wide} {LEFT}>{cell(text)}</{tag}>' for text in texts)}</tr>"


def cell(text: str) -> str:
    return f"<b>{escape(text)}</b>" if isinstance(text, Strong) else escape(text)


def html_remarks(lines: Iterable[str]) -> str:
    """What a reader should know, a paragraph each."""
    return "".join(f"<div>{cell(line)}</div>" for line in lines)
