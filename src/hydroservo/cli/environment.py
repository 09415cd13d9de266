"""What a shell hands to a command: its streams and variables."""

import io
import logging
import os
import sys
import warnings
from typing import Any

LAST_SECOND = 253402300800  # of the year 9999
COUNTS = ("OMP_NUM_THREADS", "NUMEXPR_NUM_THREADS", "NUMEXPR_MAX_THREADS")  # which numexpr reads for pandas


def prepare_environment() -> None:
    """Mend what libraries would stumble over in streams and variables, and keep these libraries quiet."""
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
    check_source_date()


def check_source_date() -> None:
    """End with a line where the date of reports is given and is not one."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "0")
    if not (epoch.isascii() and epoch.isdigit() and int(epoch) < LAST_SECOND):
        allowed = f"must be a whole number of seconds since 1970, below {LAST_SECOND}"
        sys.stderr.write(f"hydroservo: SOURCE_DATE_EPOCH = {epoch!r}: {allowed}\n")
        sys.exit(2)


class Lossy(io.FileIO):
    """A file that loses what it cannot take, so that a full disk under stderr changes no result."""

    def write(self, data: Any, /) -> int:
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
