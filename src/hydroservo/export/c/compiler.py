"""The C compiler of this computer: that of the environment's CC, or else the first of cc, gcc and clang.

A CC that is set is the one to take, so that where it does not work no other is tried.
"""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from hydroservo.errors import HydroservoError

BITS = ("-ffp-contract=off", "-fno-math-errno")  # what the results need, and square roots without a call
COMPILERS = ("cc", "gcc", "clang")
PATIENCE = 120.0  # s


class CompilerError(HydroservoError):
    """There is no C compiler, or it or its program does not work."""


def compiled(folder: Path, words: Sequence[str], made: str, command: Sequence[str] = ()) -> Path:
    """A file that the C compiler makes in a folder.

    Args:
        folder: of the sources; names relative to it keep the host's paths out of what is made.
        words: sources and options, besides those for the standard, the bits and the optimization.
        made: name of the file.
        command: that calls the compiler; this computer's own if empty.
    """
    call = [*(command or compiler()), "-std=c99", "-O2", *BITS, *words, "-o", made, "-lm"]
    done = ran(folder, call)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        said = lines[0] if lines else f"exit status {done.returncode}"
        raise CompilerError(f"the C compiler {call[0]} fails: {said}")
    if not (folder / made).exists():
        raise CompilerError(f"the C compiler {call[0]} writes no file")
    return folder / made


def compiler() -> list[str]:
    """The command of the C compiler."""
    own = os.environ.get("CC", "")
    try:
        chosen = shlex.split(own)
    except ValueError as error:
        raise HydroservoError(f"CC = {own}: {error}") from None
    if chosen and shutil.which(chosen[0]) is None:
        raise HydroservoError(f"CC names the C compiler {chosen[0]}, which is not found")
    found = chosen or [name for name in COMPILERS if shutil.which(name)][:1]
    if not found:
        raise CompilerError("no C compiler was found; install gcc or clang, or set CC")
    return found


def ran(folder: Path, command: Sequence[str]) -> "subprocess.CompletedProcess[str]":
    """What a command did in a folder."""
    name = Path(command[0]).name
    try:
        return subprocess.run(  # noqa: S603 - the compiler that the user names, and no shell
            command,
            cwd=folder,
            env={**os.environ, "TMPDIR": str(folder.absolute())},  # else one that is killed leaves files
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except OSError as error:
        raise CompilerError(f"{name} cannot be run: {error.strerror}") from error
    except subprocess.TimeoutExpired:
        raise CompilerError(f"{name} takes longer than {PATIENCE:g} s") from None
