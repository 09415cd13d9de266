"""Programs for other platforms, built by cross compilers and run by emulators."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from hydroservo.export.platforms import TOOLCHAINS, Platform
from needs import needs

__all__ = ["EMULATED", "Emulated", "run", "wine_folder"]

PATIENCE = 120.0  # s; the first program under wine makes its folder


class Emulated(NamedTuple):
    """How programs for another platform are run here.

    Attributes:
        platform: what they are for.
        emulator: words before the program.
    """

    platform: Platform
    emulator: tuple[str, ...]

    @property
    def compiler(self) -> str:
        return TOOLCHAINS[self.platform].cross

    def need(self) -> None:
        needs(self.compiler, self.emulator[0])


EMULATED = (
    Emulated(Platform.AARCH64_LINUX, ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu")),
    Emulated(Platform.X86_64_WINDOWS, ("wine",)),
)


@contextmanager
def wine_folder(folder: Path) -> Iterator[None]:
    """Wine keeps its own in this folder, of some 700 MB, which is gone afterwards."""
    before = os.environ.copy()
    os.environ |= {"WINEPREFIX": str(folder), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}
    try:
        yield
    finally:
        if folder.exists():
            run(folder.parent, "wine", "wineboot", "--kill")
            shutil.rmtree(folder, ignore_errors=True)
        os.environ.clear()
        os.environ.update(before)


def run(folder: Path, *words: str, given: str | None = None) -> str:
    """What a command prints, run in a folder."""
    done = subprocess.run(
        words, cwd=folder, input=given, capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert done.returncode == 0, f"{' '.join(words)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done.stdout
