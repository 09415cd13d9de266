"""How far single precision is from double, measured by running the C."""

import os
import shlex
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

__all__ = ["measured_deviation"]

COMPILERS = ("cc", "gcc", "clang")
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")
PATIENCE = 120.0  # s


def measured_deviation(prefix: str, texts: Mapping[str, str]) -> str | None:
    """What the replay of an export in single precision prints.

    Args:
        prefix: of the export.
        texts: its files by name.

    Returns:
        The lines it prints; None where there is no C compiler whose programs run here. The compiler is $CC
        if that is set, else cc, gcc or clang.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="utf-8")
        return next(filter(None, (replayed(compiler, prefix, folder) for compiler in compilers())), None)


def compilers() -> Iterator[list[str]]:
    """The commands that may compile C here."""
    own = os.environ.get("CC", "")
    with suppress(ValueError):  # of a quotation that does not end
        yield from filter(None, [shlex.split(own)])
    for name in COMPILERS:
        yield [name]


def replayed(compiler: list[str], prefix: str, folder: Path) -> str | None:
    """What the replay prints; None where it cannot be built or run."""
    program = folder / "replay"
    sources = [str(folder / f"{prefix}{ending}.c") for ending in ("_replay", "")]
    try:
        built = run([*compiler, *OPTIONS, "-o", str(program), *sources, "-lm"])
        if built.returncode != 0:
            return None
        found = run([str(program)])
    except (OSError, subprocess.TimeoutExpired):
        return None
    return found.stdout.strip() or None


def run(command: list[str]) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)  # noqa: S603
