"""Compiles the sources of an FMU with the host's C compiler."""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from hydroservo.errors import HydroservoError

__all__ = ["FLAGS", "compiled"]

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-shared", "-fvisibility=hidden")
COMPILERS = ("cc", "gcc", "clang")


def compiled(folder: Path, sources: Sequence[str], library: str) -> bytes:
    """A shared library of C sources, whose headers are in ``folder`` and its ``include``.

    Names are relative, so that nothing of the host's paths gets into the library.

    Raises:
        HydroservoError: there is no compiler, or it fails.
    """
    command = [*compiler(), *FLAGS, "-Iinclude", *sources, "-o", library, "-lm"]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
    except OSError as error:
        raise HydroservoError(f"the C compiler {command[0]} cannot be run: {error.strerror}") from error
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        said = lines[0] if lines else f"exit status {done.returncode}"
        raise HydroservoError(f"the C compiler {command[0]} fails: {said}")
    return (folder / library).read_bytes()


def compiler() -> list[str]:
    """The command of the C compiler: that of the environment's CC, else the first that is found.

    Raises:
        HydroservoError: there is none.
    """
    chosen = shlex.split(os.environ.get("CC", ""))
    if chosen and shutil.which(chosen[0]) is None:
        raise HydroservoError(f"CC names the C compiler {chosen[0]}, which is not found")
    found = chosen or [name for name in COMPILERS if shutil.which(name)][:1]
    if not found:
        raise HydroservoError("an FMU needs a C compiler, and none is found; install gcc or clang, or set CC")
    return found
