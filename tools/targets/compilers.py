"""Compilers and the rest: how they are called, and what says that they failed."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

from hydroservo.export.unit import CModule

# No fused multiplication and addition: it rounds once where the simulation rounds twice.
# And no errno, so that a square root is one instruction where the processor has it.
FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno")
WARNINGS = (
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wmissing-prototypes",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Werror",
)
SINGLE = ("-Wdouble-promotion",)  # an unseen double costs much where the processor has none
LONGEST = 300.0  # [s] that a tool may take


class ToolError(Exception):
    """A tool ended with another status than 0; says its command and all that it printed."""


def output(command: Sequence[str | Path]) -> str:
    """What a command prints on its standard output.

    Raises:
        ToolError: its exit status is not 0.
        subprocess.TimeoutExpired: it does not end.
    """
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    if done.returncode != 0:
        called = " ".join(str(word) for word in command)
        raise ToolError(f"{called}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def warnings(unit: CModule) -> tuple[str, ...]:
    """The compiler's warnings that a unit must not give, as errors."""
    return (*WARNINGS, *(SINGLE if unit.real == "float" else ()))
