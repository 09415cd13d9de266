"""Writes an export as an FMU: a zip of description, sources, binaries of them, and documentation."""

import io
import math
import shutil
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import BinaryIO, NamedTuple

from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.outputs import atomic_path, temporary_folder
from hydroservo.export.compilers import (
    TOOLCHAINS,
    CompilerError,
    Platform,
    compile_file,
    compiler,
    machine_name,
    platforms_named,
)
from hydroservo.export.fmu.contents import Files, fmu_files, installed_package, interface_of
from hydroservo.export.fmu.variables import FmiVariable, VariableKind, base_unit, variables_of
from hydroservo.export.texts import render
from hydroservo.export.unit import CModule, FmiVersion, Part

AS_LIBRARY = ("-fPIC", "-shared", "-fvisibility=hidden")
TRIAL = "#include <math.h>\n#include <stdlib.h>\n"  # a compiler without its C library has neither
EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in the zip, so that equal content gives equal bytes


def compiler_for(platform: Platform) -> list[str]:
    """The command of the C compiler for a platform: this computer's own, else the cross compiler."""
    if platform == machine_name():
        return compiler()
    toolchain = TOOLCHAINS[platform]
    if not toolchain.cross:
        raise CompilerError(f"a binary for {platform} can only be built on such a machine")
    if shutil.which(toolchain.cross) is None:
        raise CompilerError(f"the C compiler {toolchain.cross} is not found; {install_advice(platform)}")
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
                compile_file(folder, [*compiler_options(platform), "trial.c"], library, command)
            except CompilerError as error:
                raise CompilerError(f"{error}; {install_advice(platform)}") from error


def install_advice(platform: Platform) -> str:
    return f"for {platform}, on Debian: apt-get install {TOOLCHAINS[platform].packages}"


def compiler_options(platform: Platform) -> tuple[str, ...]:
    return (*AS_LIBRARY, *TOOLCHAINS[platform].options)


def binaries(
    files: Files, unit: CModule, version: FmiVersion, platforms: Iterable[Platform]
) -> dict[str, bytes]:
    """A shared library for each platform, and licences of what cross compilers link, by path in the FMU."""
    content = {}
    for platform in platforms:
        place = library_place(version, unit.prefix, platform)
        content[place] = library_of(files, unit, version, platform)
        if licence := TOOLCHAINS[platform].licence:
            content["documentation/licenses/mingw-w64.txt"] = runtime_licence(Path(licence))
    return content


def library_place(version: FmiVersion, name: str, platform: Platform) -> str:
    """Where in an FMU a version of FMI wants the library for a platform."""
    toolchain = TOOLCHAINS[platform]
    folder = toolchain.folder if version is FmiVersion.FMI2 else platform
    return f"binaries/{folder}/{name}{toolchain.ending}"


def runtime_licence(file: Path) -> bytes:
    """The terms of MinGW-w64's runtime as its package has them, or else where they are."""
    return file.read_bytes() if file.exists() else b"The terms of MinGW-w64's runtime: www.mingw-w64.org\n"


def library_of(files: Files, unit: CModule, version: FmiVersion, platform: Platform) -> bytes:
    """The shared library that the compiler for a platform makes of the sources."""
    with temporary_folder() as folder:
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8", newline="\n")
        sources = folder / "sources"
        names = sorted(one.name for one in sources.glob("*.c"))
        library = f"{unit.prefix}{TOOLCHAINS[platform].ending}"
        unprefixed = interface_of(version, unit.part).unprefixed
        words = [*compiler_options(platform), f"-D{unprefixed}", "-Iinclude", *names]
        return compile_file(sources, words, library, compiler_for(platform)).read_bytes()


def write_fmu(
    unit: CModule,
    path: Path | str,
    *,
    stop_time: float,
    version: FmiVersion = FmiVersion.FMI2,
    clocked: bool = False,
    platforms: Iterable[str] = (),
) -> Path:
    """Write an export as an FMU, with binaries.

    One of equations is for model exchange, others are for co-simulation. The same export gives the same bytes
    with the same compilers. The file is written whole or not at all.

    Args:
        unit: what it holds; in double precision, with its parameters as variables.
        path: of the file, which ends in ".fmu".
        stop_time: of the default experiment [s]; a whole number of sample periods.
        version: of FMI.
        clocked: with an event mode and a clock whose ticks take the samples, of a controller in FMI 3.0.
        platforms: what it holds binaries for: a ``Platform``, or its name in FMI 3.0. Others than this
            machine's, which is the one where none is named, take cross compilers.

    Returns:
        The path written.

    Raises:
        ParameterError: the export is in single precision, has its parameters inlined or cannot have a clock,
            or a name, the stop time or a platform cannot be those of an FMU.
        HydroservoError: the ending is another, the package fmpy or a C compiler is missing or fails, or the
            file cannot be written.

    Fails to run the binaries for other platforms: an error of a cross compiler would stay unseen.
    """
    path = checked_ending(Path(path))
    content = fmu_content(unit, stop_time, version, platforms, clocked=clocked)
    with atomic_path(path) as temporary:
        pack(content, temporary)
    return path


def fmu_content(
    unit: CModule, stop_time: float, version: FmiVersion, platforms: Iterable[str], *, clocked: bool = False
) -> dict[str, bytes]:
    """All files of an FMU, as :func:`write_fmu` packs them."""
    check_fit_for_fmu(unit, stop_time)
    chosen = platforms_named(platforms)
    files = fmu_files(unit, stop_time, version, clocked)
    content = {name: text.encode() for name, text in files.items()}
    return content | binaries(files, unit, version, chosen)


def check_tools(platforms: Iterable[str] = ()) -> list[Platform]:
    """Find out before a long computation whether an FMU with binaries for these platforms can be made here.

    Returns:
        The platforms, each once; this machine's where none is named.

    Raises:
        ParameterError: a name is that of no platform.
        HydroservoError: the package fmpy or a C compiler is missing, or a cross compiler does not work.
    """
    installed_package("fmpy")
    chosen = platforms_named(platforms)
    check_compilers(chosen)
    return chosen


def checked_ending(path: Path, ending: str = ".fmu") -> Path:
    """The path of an FMU, or of a system of them.

    Raises:
        HydroservoError: its ending is another.
    """
    if path.suffix.lower() != ending:
        raise HydroservoError(f"{path}: its name must end in {ending}")
    return path


def check_fit_for_fmu(unit: CModule, stop_time: float) -> None:
    if unit.real != "double":
        raise ParameterError("precision", unit.real, "an FMU is in double precision")
    if unit.inlined:
        raise ParameterError("inlined", True, "an FMU has its parameters as variables; do not inline them")
    if not 0.0 < stop_time < math.inf:
        raise ParameterError("stop_time", stop_time, "must be positive and finite")


def pack(content: Mapping[str, bytes], file: Path | BinaryIO) -> None:
    """A zip with these files, whose bytes depend on nothing else."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whose permissions follow
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content[name])


# Stepped one after the other in this order, each is given what the others put out at its sample.
PARTS = (Part.CONTROLLER, Part.MACHINE, Part.DEMAND)

OPEN = "external."  # what the names of inputs begin with that no unit here feeds


class Connection(NamedTuple):
    """From an output to an input of the same name."""

    start: Part
    end: Part
    name: str


def write_ssp(
    units: Mapping[Part, CModule],
    path: Path | str,
    *,
    stop_time: float,
    version: FmiVersion = FmiVersion.FMI2,
    platforms: Iterable[str] = (),
) -> Path:
    """Write the demand, the controller and the machine of a loop as FMUs, and how they are connected.

    Inputs for units of others, such as the machine's ``external.force``, are left without a connector.
    The same exports give the same bytes with the same compilers. The file is written whole or not at all.

    Args:
        units: the exports of the three parts.
        path: of the file, which ends in ".ssp".
        stop_time: of the default experiment [s]; a whole number of sample periods.
        version: of FMI.
        platforms: those that the FMUs hold binaries for, as of :func:`write_fmu`.

    Returns:
        The path written.

    Raises:
        ParameterError, HydroservoError: as of :func:`write_fmu`; and an input is no unit's output.

    Source: SSP 1.0, https://ssp-standard.org.
    Fails to say in which order a tool shall ask: one that reads all outputs before it sets any input delays
    each command by a period, whatever the dependencies in the FMUs say.
    """
    path = checked_ending(Path(path), ".ssp")
    chosen = platforms_named(platforms)
    content = {f"resources/{part}.fmu": fmu_of(units[part], stop_time, version, chosen) for part in PARTS}
    links = list(connections(units))
    ports = {part: connectors(part, units[part], links) for part in PARTS}
    context = {
        "units": {part: units[part] for part in PARTS},
        "connectors": ports,
        "base_units": base_units(one.unit for part in PARTS for one in ports[part]),
        "connections": links,
        "stop_time": stop_time,
    }
    content["SystemStructure.ssd"] = render("fmu/SystemStructure.xml", context).encode()
    with atomic_path(path) as temporary:
        pack(content, temporary)
    return path


def fmu_of(unit: CModule, stop_time: float, version: FmiVersion, platforms: Iterable[str]) -> bytes:
    packed = io.BytesIO()
    pack(fmu_content(unit, stop_time, version, platforms), packed)
    return packed.getvalue()


def connectors(part: Part, unit: CModule, links: Iterable[Connection]) -> list[FmiVariable]:
    """The outputs of an FMU and its inputs that are connected: a tool may connect any other as it likes."""
    fed = {link.name for link in links if link.end is part}
    return [one for one in variables_of(unit) if one.kind is VariableKind.OUTPUT or one.name in fed]


def base_units(names: Iterable[str]) -> dict[str, Mapping[str, int | float]]:
    """By its name each unit that SSP can say in terms of base units."""
    bases = {name: base_unit(name) for name in names if name}
    return {name: base for name, base in bases.items() if base is not None}


def connections(units: Mapping[Part, CModule]) -> Iterator[Connection]:
    """From each output to the inputs of other units that have its name."""
    variables = {part: variables_of(units[part]) for part in PARTS}
    outputs = {one.name: part for part in PARTS for one in variables[part] if one.kind is VariableKind.OUTPUT}
    for part in PARTS:
        for one in variables[part]:
            if one.kind is not VariableKind.INPUT or one.name.startswith(OPEN):
                continue
            if one.name not in outputs:
                raise HydroservoError(f"the input {one.name} of the {part} is not an output of another unit")
            yield Connection(outputs[one.name], part, one.name)
