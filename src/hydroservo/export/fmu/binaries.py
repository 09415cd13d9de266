"""The binaries of an FMU: shared libraries that the compiler of each platform makes of the sources."""

import shutil
from collections.abc import Iterable
from pathlib import Path

from hydroservo.export.c.compiler import CompilerError, compiled, compiler
from hydroservo.export.fmu.contents import Files
from hydroservo.export.fmu.interface import interface_of
from hydroservo.export.platforms import TOOLCHAINS, Platform, machine_name
from hydroservo.export.unit import FmiVersion, Unit
from hydroservo.outputs import temporary_folder

AS_LIBRARY = ("-fPIC", "-shared", "-fvisibility=hidden")
TRIAL = "#include <math.h>\n#include <stdlib.h>\n"  # a compiler without its C library has neither


def compiler_for(platform: Platform) -> list[str]:
    """The command of the C compiler for a platform: this computer's own, else the cross compiler."""
    if platform == machine_name():
        return compiler()
    toolchain = TOOLCHAINS[platform]
    if not toolchain.cross:
        raise CompilerError(f"a binary for {platform} can only be built on such a machine")
    if shutil.which(toolchain.cross) is None:
        raise CompilerError(f"the C compiler {toolchain.cross} is not found; {advice(platform)}")
    return [toolchain.cross]


def check_compilers(platforms: Iterable[Platform]) -> None:
    """Find out before a long computation whether binaries for these platforms can be built."""
    for platform in platforms:
        command = compiler_for(platform)
        if platform == machine_name():
            continue
        with temporary_folder() as folder:
            (folder / "trial.c").write_text(TRIAL, encoding="utf-8")
            try:
                library = f"trial{TOOLCHAINS[platform].ending}"
                compiled(folder, [*options(platform), "trial.c"], library, command)
            except CompilerError as error:
                raise CompilerError(f"{error}; {advice(platform)}") from error


def advice(platform: Platform) -> str:
    return f"for {platform}, on Debian: apt-get install {TOOLCHAINS[platform].packages}"


def options(platform: Platform) -> tuple[str, ...]:
    return (*AS_LIBRARY, *TOOLCHAINS[platform].options)


def binaries(
    files: Files, unit: Unit, version: FmiVersion, platforms: Iterable[Platform]
) -> dict[str, bytes]:
    """A shared library for each platform, and the licences of what cross compilers link into them.

    Args:
        files: the other files of the FMU, by their path in it.
        unit: what the FMU holds.
        version: of FMI.
        platforms: for which.

    Returns:
        The content of each file by its path in the FMU.
    """
    content = {}
    for platform in platforms:
        place = place_of(version, unit.prefix, platform)
        content[place] = library_of(files, unit, version, platform)
        if licence := TOOLCHAINS[platform].licence:
            content["documentation/licenses/mingw-w64.txt"] = runtime_licence(Path(licence))
    return content


def place_of(version: FmiVersion, name: str, platform: Platform) -> str:
    """Where in an FMU a version of FMI wants the library for a platform."""
    toolchain = TOOLCHAINS[platform]
    folder = toolchain.folder if version is FmiVersion.FMI2 else platform
    return f"binaries/{folder}/{name}{toolchain.ending}"


def runtime_licence(file: Path) -> bytes:
    """The terms of MinGW-w64's runtime as its package has them, or else where they are."""
    return file.read_bytes() if file.exists() else b"The terms of MinGW-w64's runtime: www.mingw-w64.org\n"


def library_of(files: Files, unit: Unit, version: FmiVersion, platform: Platform) -> bytes:
    """The shared library that the compiler for a platform makes of the sources."""
    with temporary_folder() as folder:
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8", newline="\n")
        sources = folder / "sources"
        names = sorted(one.name for one in sources.glob("*.c"))
        library = f"{unit.prefix}{TOOLCHAINS[platform].ending}"
        unprefixed = interface_of(version, unit.part).unprefixed
        words = [*options(platform), f"-D{unprefixed}", "-Iinclude", *names]
        return compiled(sources, words, library, compiler_for(platform)).read_bytes()
