"""What a result says, once, whoever asks: a terminal, a report, a notebook, a spreadsheet or a program."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.show.table import Mark, Table

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot

FileWriter = Callable[[Path], object]
NO_FILES: Mapping[str, FileWriter] = MappingProxyType({})


class Line(NamedTuple):
    """A sentence or two.

    Attributes:
        lead: its first words, which stand out where there is a mark.
        rest: those that follow.
        mark: how the lead stands out.
        command: to be typed in a shell; it follows the words, and is never broken into lines.
    """

    lead: str
    rest: str = ""
    mark: Mark | None = None
    command: str = ""

    def __str__(self) -> str:
        return f"{self.lead}{self.rest} {self.command}".rstrip()


class Picture(NamedTuple):
    """A picture.

    Attributes:
        name: of its files.
        caption: what it shows.
        draw: makes it.
    """

    name: str
    caption: str
    draw: "Callable[[], Plot]"


class Origin(NamedTuple):
    """A scenario that a result is of.

    Attributes:
        name: as it was asked for.
        hash: names it with all its numbers.
        seed: of its noise.
        text: all its numbers, as TOML in SI units.
    """

    name: str
    hash: str
    seed: int
    text: str


class Log(NamedTuple):
    """A log that a result is of.

    Attributes:
        name: of its file.
        digest: SHA-256 of the file.
    """

    name: str
    digest: str


def title_of(what: str, name: str) -> str:
    """The title of a finding: what it is, and of which scenario where that has a name."""
    return f"{what} of {name}" if name else what


def logs_in(files: Iterable[Path]) -> list[Log]:
    """The logs in files; one that can be read only once, such as a pipe, has no digest any more."""
    return [
        Log(str(file), hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else "")
        for file in files
    ]


class Finding(NamedTuple):
    """What a result says.

    Attributes:
        title: what it is of.
        lead: what was found, in sentences, the most important first.
        remarks: what a reader should be warned of.
        tables: the numbers to read.
        pictures: the first shows the result alone.
        numbers: all of them in SI units, by the keys of ``--json`` and ``metrics.json``.
        files: those of a folder besides its report, and what writes each.
        origins: the scenarios.
        logs: of a machine, where it is of some.
    """

    title: str
    lead: Sequence[Line]
    remarks: Sequence[str]
    tables: Sequence[Table]
    pictures: Sequence[Picture]
    numbers: Mapping[str, Any]
    files: Mapping[str, FileWriter] = NO_FILES
    origins: Sequence[Origin] = ()
    logs: Sequence[Log] = ()

    @property
    def filled(self) -> list[Table]:
        """Its tables that have rows."""
        return [table for table in self.tables if table.rows]

    @property
    def doubts(self) -> list[Line]:
        """The lines of its lead that are bad or doubtful."""
        return [line for line in self.lead if line.mark in (Mark.BAD, Mark.DOUBTFUL)]
