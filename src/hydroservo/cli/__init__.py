"""The command line."""

import io
import logging
import os
import sys
import warnings

from hydroservo.cli.interrupts import (
    INTERRUPTED,
    discard_unwritten,
    end_on_interrupt,
    ignore_interrupts,
    leave,
    repeat_interrupts,
)

TYPE_CHECKING = False  # as typing has it, which need not be imported for it
if TYPE_CHECKING:
    from typing import Any

__all__ = ["main"]

LAST_SECOND = 253402300800  # of the year 9999
COUNTS = ("OMP_NUM_THREADS", "NUMEXPR_NUM_THREADS", "NUMEXPR_MAX_THREADS")  # which numexpr reads for pandas


def main() -> None:
    """The ``hydroservo`` command.

    An interrupt before it is called is Python's own matter: this module and those above it import next to
    nothing, so that it is called soon.
    """
    end_on_interrupt()
    settle_surroundings()
    from hydroservo.cli.app import app

    try:
        repeat_interrupts()
        try:
            app(prog_name="hydroservo")
        finally:
            ignore_interrupts()
    except KeyboardInterrupt:  # outside of any command, which would have heard it
        leave()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            leave()
        raise
    finally:
        discard_unwritten()


def settle_surroundings() -> None:
    """Keep what a shell hands over from libraries that would stumble over it, and quieten these."""
    open_closed_streams()
    if isinstance(sys.stderr, io.TextIOWrapper) and os.name == "posix":
        lossy = io.BufferedWriter(Lossy(sys.stderr.fileno(), "w", closefd=False))
        sys.stderr = io.TextIOWrapper(lossy, sys.stderr.encoding, line_buffering=True)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that lacks a sign shows ? for it
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices of six rows: threads cost more than they do
    os.environ["MPLBACKEND"] = "agg"  # pictures are files
    for name in COUNTS:
        if not os.environ.get(name, "1").isdecimal():
            del os.environ[name]
    if not sys.warnoptions:  # what libraries say; hydroservo's own warnings are lines
        warnings.simplefilter("ignore")
        logging.getLogger("matplotlib").setLevel(logging.ERROR)
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "0")
    if not (epoch.isascii() and epoch.isdigit() and int(epoch) < LAST_SECOND):
        allowed = f"must be a whole number of seconds since 1970, below {LAST_SECOND}"
        sys.stderr.write(f"hydroservo: SOURCE_DATE_EPOCH = {epoch!r}: {allowed}\n")
        sys.exit(2)


class Lossy(io.FileIO):
    """A file that loses what it cannot take, so that a full disk under stderr changes no result."""

    def write(self, data: "Any", /) -> int:
        try:
            return super().write(data)
        except OSError:
            return len(data)


def open_closed_streams() -> None:
    """Give standard streams that are closed, as by >&-, a place where nothing comes or goes.

    Otherwise the next file that is opened would be taken for one of them.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115
