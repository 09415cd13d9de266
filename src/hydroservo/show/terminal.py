"""Findings, tables and lines on a terminal."""

import sys
from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table as TerminalTable

from hydroservo.show.finding import Finding, Line
from hydroservo.show.table import Mark, Table, TableTexts, note_of, texts_of

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


def console_of(width: int = 0) -> Console:
    """Stdout, as wide as its terminal, or wider."""
    console = Console(width=None if sys.stdout.isatty() else PIPED_WIDTH, highlight=False, emoji=False)
    console.width = max(width, console.width)
    return console


def show(*things: "RenderableType", whole: bool = False) -> None:
    """Print to stdout, in colour if that is a terminal."""
    console = console_of()
    for thing in things:
        console.print(thing, soft_wrap=whole)


def show_table(table: Table, *, titled: bool = True) -> None:
    """Print a table; without what its numbers mean, and wider than the terminal, where it has no room."""
    console = console_of()
    if table.columns[-1].heading == "meaning" and width_of(texts_of(table)) > console.width:
        table = table._replace(columns=table.columns[:-1], rows=[row[:-1] for row in table.rows])
    console = console_of(width_of(texts_of(table)))
    console.print(terminal_table(table, console.width, titled=titled))


def width_of(texts: TableTexts) -> int:
    """The characters of a line of a table in which no number and no short text is broken."""
    return sum(size + 3 for size in sizes_of(texts)) + 1


def sizes_of(texts: TableTexts) -> list[int]:
    """The least width of each column."""
    cells = [max(map(len, column), default=0) for column in zip(*texts.rows, strict=True)]
    words = [max(map(len, heading.split()), default=0) for heading in texts.headings]
    return [max(min(size, LONG), word) for size, word in zip(cells, words, strict=True)]


def show_finding(finding: Finding) -> None:
    """Print what a result says: its title, its tables, and what was found."""
    origins = finding.origins
    about = f"   (hash {origins[0].hash}, seed {origins[0].seed})" if len(origins) == 1 else ""
    show(f"[bold]{escape(finding.title)}[/]{about}")
    for table in finding.filled:
        show_table(table, titled=len(finding.filled) > 1)
    for line in finding.lead:
        show(terminal_line(line), whole=bool(line.command))


def terminal_line(line: Line) -> str:
    """A line with the colour of its mark."""
    return marked_up(line.lead, line.mark) + escape(f"{line.rest} {line.command}".rstrip())


def marked_up(text: str, mark: Mark | None) -> str:
    return f"[{STYLES[mark]}]{escape(text)}[/]" if mark and text else escape(text)


def terminal_table(table: Table, width: int, *, titled: bool = True) -> TerminalTable:
    """A table; what is best has a star too, for terminals without colours."""
    texts = texts_of(table)
    title = escape(table.title) if titled and table.title else None
    note = note_of(table, "*")
    shown = TerminalTable(
        title=title, title_justify="left", caption=escape(note) or None, caption_justify="left"
    )
    sizes = sizes_of(texts)
    whole = [max(pair) for pair in zip(sizes, map(len, texts.headings), strict=True)]
    sizes = whole if sum(whole) + 3 * len(whole) < width else sizes
    for j, (heading, right) in enumerate(zip(texts.headings, texts.right, strict=True)):
        long = max((len(row[j]) for row in texts.rows), default=0) > LONG
        head = heading if long else fill(heading, sizes[j])
        shown.add_column(
            escape(head), justify="right" if right else "left", no_wrap=not long, overflow="fold"
        )
    starred = [any(row[j].mark is Mark.BEST for row in table.rows) for j in range(len(table.columns))]
    for row, cells in zip(texts.rows, table.rows, strict=True):
        shown.add_row(
            *(
                marked_up(f"{text} *" if cell.mark is Mark.BEST else f"{text}  " if star else text, cell.mark)
                for text, cell, star in zip(row, cells, starred, strict=True)
            )
        )
    return shown
