"""What each controller takes on each processor, measured and as tables."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.table import Line, markdown
from hydroservo.export.unit import CModule
from tools.targets.boards import BOARDS, COMPILER
from tools.targets.callgrind import instructions
from tools.targets.compilers import output
from tools.targets.costs import Costs, costs
from tools.targets.sources import Rows

__all__ = ["Measured", "measured", "page", "tables"]

PRECISIONS = {"double": "double precision", "float": "single precision"}


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


def measured(units: Iterable[tuple[str, CModule, Rows]], say: Callable[[str], None]) -> Iterator[Measured]:
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
    """The instructions of a step, and the memory in each precision, by title."""
    memory = []
    for real, title in PRECISIONS.items():
        rows = [memory_row(one) for one in found if one.real == real]
        memory.append((f"Bytes of memory, {title}", (memory_columns(), rows)))
    return [("Instructions of a step", (instruction_columns(), instruction_rows(found))), *memory]


def instruction_columns() -> Line:
    places = [*(board.name for board in BOARDS), "x86-64"]
    return ("", *(f"{place}, {title}" for title in ("double", "single") for place in places))


def instruction_rows(found: list[Measured]) -> list[Line]:
    """A row for each name, with both precisions side by side."""
    rows: dict[str, list[str]] = {}
    for one in sorted(found, key=lambda one: list(PRECISIONS).index(one.real)):
        counts = [*(board.instructions for board in one.boards), one.instructions]
        rows.setdefault(one.name, []).extend(f"{count:,}" for count in counts)
    return [(name, *cells) for name, cells in rows.items()]


def memory_columns() -> Line:
    each = [f"{board.name}: {what}" for board in BOARDS for what in ("code", "with libraries", "stack")]
    return ("", "state", "parameters", *each)


def memory_row(one: Measured) -> Line:
    first = one.boards[0]
    cells = [text for found in one.boards for text in board_cells(found)]
    return (one.name, f"{first.state:,}", f"{first.parameters:,}", *cells)


def board_cells(found: Costs) -> tuple[str, ...]:
    """Code alone, with what it takes of libraries, and stack."""
    own, linked = (sections.text + sections.rodata for sections in (found.own, found.linked))
    return tuple(f"{count:,}" for count in (own, linked, max(found.stack, found.touched)))


def made_with() -> str:
    versions = {compiler: output([compiler, "-dumpfullversion"]).strip() for compiler in (COMPILER, "gcc")}
    return f"With {' and '.join(f'{name} {version}' for name, version in versions.items())}, both with -O2."
