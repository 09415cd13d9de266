"""What commands say of kernels under ``--verbose``."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import typer

LOG = logging.getLogger("hydroservo.engine")


class Lines(logging.Handler):
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
    lines = Lines()
    LOG.addHandler(lines)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.setLevel(logging.NOTSET)
        LOG.removeHandler(lines)
        for text in lines.texts:
            typer.echo(f"hydroservo: {text}", err=True)
