"""Findings, tables and lines on a terminal."""

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table as TerminalTable

from hydroservo.show.finding import Finding, Line
from hydroservo.show.table import Mark, Table, note_of, texts_of

if TYPE_CHECKING:
    from rich.console import RenderableType

PIPED_WIDTH = 120  # characters a line where there is no terminal to ask
LONG = 24  # characters of a text that may go over several lines
STYLES: Mapping[Mark | None, str] = {
    Mark.BEST: "bold green",
    Mark.GOOD: "green",
    Mark.BAD: "bold red",
    Mark.DOUBTFUL: "bold yellow",
    Mark.QUIET: "dim",
}


def show(*things: "RenderableType", whole: bool = False) -> None:
    """Print to stdout, in colour if that is a terminal.

    Args:
        things: each from a new line on.
        whole: whether a line stays one, however long it is.
    """
    console = Console(width=None if sys.stdout.isatty() else PIPED_WIDTH, highlight=False, emoji=False)
    for thing in things:
        console.print(thing, soft_wrap=whole)


def show_finding(finding: Finding) -> None:
    """Print what a result says: its title, its tables, and what was found."""
    origins = finding.origins
    about = f"   (hash {origins[0].hash}, seed {origins[0].seed})" if len(origins) == 1 else ""
    several = len(finding.filled) > 1
    show(
        f"[bold]{escape(finding.title)}[/]{about}",
        *(terminal_table(table, titled=several) for table in finding.filled),
    )
    for line in finding.lead:
        show(terminal_line(line), whole=bool(line.command))


def terminal_line(line: Line) -> str:
    """A line with the colour of its mark."""
    return coloured(line.lead, line.mark) + escape(f"{line.rest} {line.command}".rstrip())


def coloured(text: str, mark: Mark | None) -> str:
    return f"[{STYLES[mark]}]{escape(text)}[/]" if mark and text else escape(text)


def terminal_table(table: Table, *, titled: bool = True) -> TerminalTable:
    """A table; what is best has a star too, for terminals without colours."""
    texts = texts_of(table)
    title = escape(table.title) if titled and table.title else None
    note = note_of(table, "*")
    shown = TerminalTable(
        title=title, title_justify="left", caption=escape(note) or None, caption_justify="left"
    )
    for j, (heading, right) in enumerate(zip(texts.headings, texts.right, strict=True)):
        long = max((len(row[j]) for row in texts.rows), default=0) > LONG
        shown.add_column(
            escape(heading), justify="right" if right else "left", no_wrap=not long, overflow="fold"
        )
    starred = [any(row[j].mark is Mark.BEST for row in table.rows) for j in range(len(table.columns))]
    for row, cells in zip(texts.rows, table.rows, strict=True):
        shown.add_row(
            *(
                coloured(f"{text} *" if cell.mark is Mark.BEST else f"{text}  " if star else text, cell.mark)
                for text, cell, star in zip(row, cells, starred, strict=True)
            )
        )
    return shown
