"""Programs for other platforms, built by cross compilers and run by emulators."""

import subprocess
from pathlib import Path
from typing import NamedTuple

from hydroservo.export.compilers import TOOLCHAINS, Platform
from tests.support.needs import needs

PATIENCE = 120.0  # s


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


def wine_surroundings(folder: Path) -> dict[str, str]:
    """The environment in which Wine keeps its own in a folder.

    Its libraries are all that a program of the console needs; what Wine would set up besides them takes many
    seconds and 700 MB. Where they are not where Debian has them, it does so all the same.
    """
    system = folder / "drive_c" / "windows" / "system32"
    system.mkdir(parents=True)
    libraries = list(Path("/usr/lib").glob("*/wine/x86_64-windows/*.dll"))
    for library in libraries:
        (system / library.name).symlink_to(library)
    if libraries:
        (folder / ".update-timestamp").write_text("disable\n")
    return {"WINEPREFIX": str(folder), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}


def run(folder: Path, *words: str, given: str | None = None) -> str:
    """What a command prints, run in a folder."""
    done = subprocess.run(
        words, cwd=folder, input=given, capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert done.returncode == 0, f"{' '.join(words)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done.stdout
