"""What commands say of runs beside their results."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from hydroservo.control.loop import Loop

SAID: set[str] = set()  # warnings of this command

LOG = logging.getLogger("hydroservo.engine")


def warn_of_sizes(scenario: str, loop: "Loop") -> None:
    """A size that no machine has, before a run of it that may take long, on stderr."""
    from hydroservo.runs.cautions.sizes import size_cautions

    for text in size_cautions(loop):
        say_warning(scenario, text)


def say_warning(name: str, text: str) -> None:
    """A warning in one line on stderr, once a command: what is known before a run is in its result too."""
    line = ": ".join(filter(None, ["hydroservo: warning", name, text]))
    if line not in SAID:
        SAID.add(line)
        typer.echo(line, err=True)


class LogCollector(logging.Handler):
    """Keeps what is logged, for there may be a progress bar on stderr."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


@contextmanager
def log_kernels(wanted: bool) -> Iterator[None]:
    """At its end, where the kernels that were used came from, a line for each on stderr."""
    if not wanted:
        yield
        return
    lines = LogCollector()
    LOG.addHandler(lines)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.setLevel(logging.NOTSET)
        LOG.removeHandler(lines)
        for text in lines.texts:
            typer.echo(f"hydroservo: {text}", err=True)
