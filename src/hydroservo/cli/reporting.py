"""What a command shows on the terminal, as the tables and sentences of its report."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rich.table import Table as TerminalTable
from rich.text import Text

from hydroservo.cli.typed import command_typed
from hydroservo.reports.table import Column, Table

if TYPE_CHECKING:
    import typer
    from rich.console import RenderableType

MARK = " *"  # behind what is best, on a terminal


def again(context: "typer.Context") -> str:
    """The command that makes a report again, into a folder."""
    first, *options = command_typed(context)
    return " \\\n    ".join([f"{first} --out DIR", *options])


def sentences(lines: "Iterable[RenderableType]") -> list[str]:
    """Lines of a terminal without their colours."""
    return [plain(line) for line in lines]


def in_one_block(lines: Sequence[str]) -> list[str]:
    """Remarks one below the other, as one remark; none where there are no lines."""
    return ["\n".join(lines)] if lines else []


def table_of(name: str, shown: TerminalTable, title: str = "") -> Table:
    """A terminal's table without its colours; what is marked there as best is marked.

    Args:
        name: of its files.
        shown: the table.
        title: in place of its own.
    """
    columns = [Column(plain(one.header), one.justify == "right") for one in shown.columns]
    texts = list(zip(*([plain(cell) for cell in one.cells] for one in shown.columns), strict=True))
    marked = frozenset(
        (i, j) for i, row in enumerate(texts) for j, text in enumerate(row) if text.endswith(MARK)
    )
    rows = [[text.removesuffix(MARK) for text in row] for row in texts]
    note = plain(shown.caption or "")
    note = note[:1].upper() + note[1:]
    if marked:
        note = note.replace("* best", "Bold: the best")
    return Table(name, columns, rows, title or plain(shown.title or ""), note, marked)


def plain(shown: "RenderableType") -> str:
    """The text of what a terminal shows."""
    return (Text.from_markup(shown) if isinstance(shown, str) else Text(str(shown))).plain.strip()
