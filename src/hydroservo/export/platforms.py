"""The platforms that binaries are for: their names, and what builds for them."""

import platform
import sys
from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from hydroservo.errors import HydroservoError, ParameterError


class Platform(StrEnum):
    """A processor and an operating system, by their name in FMI 3.0."""

    X86_64_LINUX = "x86_64-linux"
    AARCH64_LINUX = "aarch64-linux"
    X86_64_WINDOWS = "x86_64-windows"
    X86_64_DARWIN = "x86_64-darwin"
    AARCH64_DARWIN = "aarch64-darwin"
    X86_LINUX = "x86-linux"
    X86_WINDOWS = "x86-windows"
    AARCH64_WINDOWS = "aarch64-windows"


class Toolchain(NamedTuple):
    """What makes a binary for a platform, and where it goes in an FMU.

    Attributes:
        folder: of its binaries in FMI 2.0, which has names of its own for x86, and since 2.0.4 those of FMI
            3.0 for all others.
        ending: of a shared library's name.
        options: of the compiler for a shared library, besides those for all.
        cross: the compiler for it on other machines; empty where a binary is built on such a machine alone.
        packages: of Debian, with that compiler and its C library.
        licence: of what that compiler links into a binary: its file in Debian's packages.
    """

    folder: str
    ending: str
    options: tuple[str, ...] = ()
    cross: str = ""
    packages: str = ""
    licence: str = ""


# No time of day in the file, no library of the compiler beside it, and no symbols of the compiler's own.
WINDOWS = ("-Wl,--no-insert-timestamp", "-static-libgcc", "-s")

TOOLCHAINS = {
    Platform.X86_64_LINUX: Toolchain(
        "linux64",
        ".so",
        cross="x86_64-linux-gnu-gcc",
        packages="gcc-x86-64-linux-gnu libc6-dev-amd64-cross",
    ),
    Platform.AARCH64_LINUX: Toolchain(
        "aarch64-linux",
        ".so",
        cross="aarch64-linux-gnu-gcc",
        packages="gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
    ),
    Platform.X86_64_WINDOWS: Toolchain(
        "win64",
        ".dll",
        WINDOWS,
        cross="x86_64-w64-mingw32-gcc",
        packages="gcc-mingw-w64-x86-64",
        licence="/usr/share/doc/mingw-w64-x86-64-dev/copyright",
    ),
    Platform.X86_64_DARWIN: Toolchain("darwin64", ".dylib"),
    Platform.AARCH64_DARWIN: Toolchain("aarch64-darwin", ".dylib"),
    Platform.X86_LINUX: Toolchain("linux32", ".so"),
    Platform.X86_WINDOWS: Toolchain("win32", ".dll", WINDOWS),
    Platform.AARCH64_WINDOWS: Toolchain("aarch64-windows", ".dll", WINDOWS),
}

SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
ARCHITECTURES = {
    "x86_64": "x86_64",
    "amd64": "x86_64",
    "aarch64": "aarch64",
    "arm64": "aarch64",
    "i386": "x86",
    "i686": "x86",
}


def machine_name() -> str:
    """What this machine would be called, in the manner of FMI 3.0."""
    machine = platform.machine().lower()
    return f"{ARCHITECTURES.get(machine, machine)}-{SYSTEMS.get(sys.platform, sys.platform)}"


def this_platform() -> Platform:
    """That of this machine."""
    name = machine_name()
    if name not in list(Platform):
        raise HydroservoError(f"FMI has no name for this machine, {name!r}, so no FMU can be built for it")
    return Platform(name)


def platforms_named(names: Iterable[str]) -> list[Platform]:
    """The platforms with these names, each once; this machine's where none is named."""
    chosen = dict.fromkeys(names)
    for name in chosen:
        if name not in list(Platform):
            raise ParameterError("platforms", name, f"must be one of {', '.join(Platform)}")
    return [Platform(name) for name in chosen] or [this_platform()]
