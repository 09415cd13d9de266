"""What a report says, whatever command it is of."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo.reports.table import Table
from hydroservo.runs.provenance import provenance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hydroservo.loop import Loop


class Picture(NamedTuple):
    """A picture of a report.

    Attributes:
        name: of its files.
        caption: what it shows.
        figure: it.
    """

    name: str
    caption: str
    figure: "Figure"


class Origin(NamedTuple):
    """What a report is of.

    Attributes:
        name: of the scenario, as it was asked for.
        hash: names it with all its numbers.
        seed: of its noise.
        text: all its numbers, as TOML in SI units.
    """

    name: str
    hash: str
    seed: int
    text: str


def origin_of(name: str, attributes: Mapping[Any, Any]) -> Origin:
    """The origin of a result.

    Args:
        name: of its scenario.
        attributes: those that every result carries.
    """
    return Origin(name, str(attributes["hash"]), int(attributes["seed"]), str(attributes["scenario"]))


def origin_of_loop(name: str, loop: "Loop") -> Origin:
    """The origin of what was found of a loop without a run.

    Args:
        name: of its scenario.
        loop: the scenario's.
    """
    return origin_of(name, provenance(loop, loop))


class Log(NamedTuple):
    """A log that a report is of.

    Attributes:
        name: of its file.
        digest: SHA-256 of the file.
    """

    name: str
    digest: str


def logs_of(files: Iterable[Path]) -> list[Log]:
    """The logs in files; one that can be read only once, such as a pipe, has no digest any more."""
    return [
        Log(str(file), hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else "")
        for file in files
    ]


class Report(NamedTuple):
    """All of a report.

    Attributes:
        title: what it is of.
        lead: what was found, in sentences, the most important first.
        remarks: what a reader should be warned of.
        pictures: they.
        tables: they.
        command: makes it again.
        origins: the scenarios.
        logs: of a machine, where it is of some.
    """

    title: str
    lead: Sequence[str]
    remarks: Sequence[str]
    pictures: Sequence[Picture]
    tables: Sequence[Table]
    command: str
    origins: Sequence[Origin]
    logs: Sequence[Log] = ()
