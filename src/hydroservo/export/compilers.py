"""The platforms that binaries are for, what builds for them, and the C compiler of this computer."""

import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

from hydroservo.core.errors import HydroservoError, ParameterError

BITS = ("-ffp-contract=off", "-fno-math-errno")  # what the results need, and square roots without a call
COMPILERS = ("cc", "gcc", "clang")  # tried in turn where CC is not set; one that is set is the one to take
PATIENCE = 120.0  # s


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
    """What makes a binary for a platform, and where it goes in an FMU."""

    # of its binaries in FMI 2.0, which has names of its own for x86, and since 2.0.4 those of FMI 3.0 for
    # all others
    folder: str
    ending: str  # of a shared library's name
    options: tuple[str, ...] = ()  # of the compiler for a shared library, besides those for all
    # the compiler for it on other machines; empty where a binary is built on such a machine alone
    cross: str = ""
    packages: str = ""  # of Debian, with that compiler and its C library
    licence: str = ""  # of what that compiler links into a binary: its file in Debian's packages


# No time of day in the file, no library of the compiler beside it, and no symbols of the compiler's own.
WINDOWS = ("-Wl,--no-insert-timestamp", "-static-libgcc", "-s")

TOOLCHAINS = {
    Platform.X86_64_LINUX: Toolchain(
        "linux64", ".so", cross="x86_64-linux-gnu-gcc", packages="gcc-x86-64-linux-gnu libc6-dev-amd64-cross"
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


class CompilerError(HydroservoError):
    """There is no C compiler, or it or its program does not work."""


def compile_file(folder: Path, words: Sequence[str], made: str, command: Sequence[str] = ()) -> Path:
    """A file that the C compiler makes in a folder.

    Args:
        folder: of the sources; names relative to it keep the host's paths out of what is made.
        words: sources and options, besides those for the standard, the bits and the optimization.
        made: name of the file.
        command: that calls the compiler; this computer's own if empty.
    """
    call = [*(command or compiler()), "-std=c99", "-O2", *BITS, *words, "-o", made, "-lm"]
    done = run_tool(folder, call)
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


def run_tool(folder: Path, command: Sequence[str]) -> "subprocess.CompletedProcess[str]":
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
