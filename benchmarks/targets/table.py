"""What each controller takes on each processor, measured and as tables."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.table import Line, markdown
from benchmarks.targets.boards import BOARDS, COMPILER
from benchmarks.targets.callgrind import instructions
from benchmarks.targets.costs import Costs, costs
from benchmarks.targets.sources import Rows
from benchmarks.targets.tools import output
from hydroservo.export.exported import Exported

__all__ = ["Measured", "measured", "page", "tables"]

PRECISIONS = {"double": "Double precision", "float": "Single precision"}


class Measured(NamedTuple):
    """Of one unit.

    Attributes:
        name: as the table calls it.
        real: "double" or "float".
        instructions: of a step on this machine's processor.
        boards: what it takes on each board, in the order of the boards.
    """

    name: str
    real: str
    instructions: int
    boards: tuple[Costs, ...]


def measured(units: Iterable[tuple[str, Exported, Rows]], say: Callable[[str], None]) -> Iterator[Measured]:
    """Measures each unit, by its name, with these inputs.

    Raises:
        ToolError: one does not compile, or does not run to its end.
    """
    for name, unit, inputs in units:
        say(f"{name}, {unit.real}")
        with TemporaryDirectory() as folder:
            here = Path(folder)
            found = tuple(costs(unit, board, inputs, here) for board in BOARDS)
            yield Measured(name, unit.real, instructions(unit, inputs, here), found)


def page(found: list[Measured]) -> str:
    """What the documentation shows."""
    chapters = []
    for title, (header, rows) in tables(found):
        chapters += [f"### {title}", markdown(header, ((f"`{name}`", *cells) for name, *cells in rows))]
    return "\n\n".join([*chapters, made_with()])


def tables(found: list[Measured]) -> list[tuple[str, tuple[Line, list[Line]]]]:
    """A table for each precision, by title."""
    return [
        (title, (columns(), [row(one) for one in found if one.real == real]))
        for real, title in PRECISIONS.items()
        if any(one.real == real for one in found)
    ]


def columns() -> Line:
    each = [f"{board.name}: {what}" for board in BOARDS for what in ("code", "stack", "instructions")]
    return ("", "state", "parameters", *each, "x86-64: instructions")


def row(one: Measured) -> Line:
    first = one.boards[0]
    cells = [text for found in one.boards for text in board_cells(found)]
    return (one.name, bytes_of(first.state), bytes_of(first.parameters), *cells, f"{one.instructions:,}")


def board_cells(found: Costs) -> tuple[str, str, str]:
    """Code alone and with what it takes of libraries, stack, instructions."""
    own, linked = (sections.text + sections.rodata for sections in (found.own, found.linked))
    stack = max(found.stack, found.touched)
    return f"{own:,} ({linked:,}) B", bytes_of(stack), f"{found.instructions:,}"


def bytes_of(count: int) -> str:
    return f"{count:,} B"


def made_with() -> str:
    versions = {compiler: output([compiler, "-dumpfullversion"]).strip() for compiler in (COMPILER, "gcc")}
    return f"With {' and '.join(f'{name} {version}' for name, version in versions.items())}, both with -O2."
