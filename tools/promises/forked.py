"""Commands of hydroservo as processes of their own that begin with all libraries imported.

A fork takes milliseconds where a new process takes seconds to import, and all that a command does itself it
still does in its own process.
"""

import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

LIBRARIES = (
    *("numpy", "pandas", "xarray", "pyarrow.parquet", "scipy.special", "scipy.optimize"),
    *("matplotlib.pyplot", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg"),
    *("llvmlite.binding", "pydantic", "jinja2", "typer", "rich.progress", "rich.table"),
    *("hydroservo.figures.run", "hydroservo.figures.batch", "hydroservo.export.c"),
    "encodings.unicode_escape",  # of jinja2: another user may not be able to read Python's files
    *("hydroservo.figures.studies", "hydroservo.runs.tuning", "hydroservo.studies.study"),
)


SAID = ("stdout.txt", "stderr.txt")


class Ended(NamedTuple):
    """How a command ended, and what it said."""

    status: int  # negative: the signal that ended it
    out: str
    err: str
    seconds: float


class Started(NamedTuple):
    """A command that runs, in a process group of its own."""

    pid: int
    folder: Path  # of what it says
    begun: float

    def kill(self) -> None:
        """Kill it and all that it started, at once."""
        os.killpg(self.pid, signal.SIGKILL)

    def ended(self, patience: float = 300.0) -> Ended:
        """Wait for its end; after that many seconds it is killed, which counts as a hang."""
        while not (found := os.waitpid(self.pid, os.WNOHANG))[0]:
            if time.monotonic() - self.begun > patience:
                self.kill()
            time.sleep(0.002)
        said = [(self.folder / name).read_text("utf-8", "replace") for name in SAID]
        return Ended(os.waitstatus_to_exitcode(found[1]), *said, time.monotonic() - self.begun)


def warm_up() -> None:
    """Import what commands import, and read units once."""
    for name in LIBRARIES:
        import_module(name)
    from hydroservo.cli.commands import PLACES
    from hydroservo.scenario import load_scenario

    for command in PLACES.values():
        resolve_name(f"hydroservo.cli.{command}")

    load_scenario("paper/sine-pi")


def start(words: list[str], folder: Path, prepare: Callable[[], Any] = lambda: None) -> Started:
    """Begin a command.

    Args:
        words: what follows ``hydroservo``.
        folder: for what it says.
        prepare: is called in the new process first.
    """
    folder.mkdir(parents=True, exist_ok=True)
    begun = time.monotonic()
    pid = os.fork()
    if pid:
        os.setpgid(pid, pid)
        return Started(pid, folder, begun)
    status = 1
    try:
        os.setpgid(0, 0)
        speak_into(folder)
        sys.argv = ["hydroservo", *words]
        prepare()
        status = command()
    except BaseException:
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)


def speak_into(folder: Path) -> None:
    """Let what this process says go to files."""
    for number, name in enumerate(SAID, 1):
        handle = os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(handle, number)
        os.close(handle)


def command() -> int:
    from hydroservo.cli import main

    try:
        main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0
