"""The command line."""

import io
import os
import sys
from typing import NoReturn

from hydroservo.cli.interrupts import INTERRUPTED, heard, repeat_interrupts

__all__ = ["main"]


def main() -> None:
    """The ``hydroservo`` command."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that lacks a sign shows ? for it
    repeat_interrupts()
    try:
        from hydroservo.cli.app import app

        app(prog_name="hydroservo")
    except KeyboardInterrupt:  # before there was a command to hear it
        leave()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            leave()
        raise
    finally:
        discard_unwritten()


def leave() -> NoReturn:
    """End at once: Python may crash as it closes an interrupted compiler, and nothing is left to do."""
    heard()
    sys.stderr.write("hydroservo: interrupted; nothing was left half-written\n")
    sys.stderr.flush()
    discard_unwritten()
    os._exit(INTERRUPTED)


def discard_unwritten() -> None:
    """Keep Python from complaining at its exit of output that nobody takes any more."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
