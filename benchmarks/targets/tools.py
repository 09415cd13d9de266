"""Compilers and the rest: how they are called, and what says that they failed."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

__all__ = ["FLAGS", "WARNINGS", "ToolError", "output"]

# No fused multiplication and addition: it rounds once where the simulation rounds twice.
FLAGS = ("-std=c99", "-ffp-contract=off")
WARNINGS = (
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wmissing-prototypes",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Werror",
)
LONGEST = 300.0  # [s] that a tool may take


class ToolError(Exception):
    """A tool ended with another status than 0; says its command and all that it printed."""


def output(command: Sequence[str | Path]) -> str:
    """What a command prints on its standard output.

    Raises:
        ToolError: its exit status is not 0.
        subprocess.TimeoutExpired: it does not end.
    """
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)  # noqa: S603
    if done.returncode != 0:
        called = " ".join(str(word) for word in command)
        raise ToolError(f"{called}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout
