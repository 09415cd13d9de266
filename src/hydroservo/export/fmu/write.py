"""Writes an export as an FMU: a zip of description, sources, a binary of them, and documentation."""

import math
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.export.c.compiler import compiled, compiler
from hydroservo.export.fmu.contents import Files, fmu_files
from hydroservo.export.fmu.headers import package
from hydroservo.export.fmu.interface import binary_ending, interface_of, platform_folder
from hydroservo.export.unit import FmiVersion, Unit
from hydroservo.outputs import atomic_path

__all__ = ["check_tools", "checked_ending", "fmu_content", "pack", "write_fmu"]

AS_LIBRARY = ("-fPIC", "-shared", "-fvisibility=hidden")
EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in the zip, so that equal content gives equal bytes


def write_fmu(
    exported: Unit,
    path: Path | str,
    *,
    stop_time: float,
    version: FmiVersion = FmiVersion.FMI2,
    clocked: bool = False,
) -> Path:
    """Write an export as an FMU, with a binary for this machine.

    One of equations is for model exchange, others are for co-simulation. The same export gives the same bytes
    with the same compiler. The file is written whole or not at all.

    Args:
        exported: what it holds; in double precision, with its parameters as variables.
        path: of the file, which ends in ".fmu".
        stop_time: of the default experiment [s]; a whole number of sample periods.
        version: of FMI.
        clocked: with an event mode and a clock whose ticks take the samples, of a controller in FMI 3.0.

    Returns:
        The path written.

    Raises:
        ParameterError: the export is in single precision, has its parameters inlined or cannot have a clock,
            or a name or the stop time cannot be those of an FMU.
        HydroservoError: the ending is another, the package fmpy or a C compiler is missing or fails, or the
            file cannot be written.
    """
    path = checked_ending(Path(path))
    content = fmu_content(exported, stop_time, version, clocked)
    with atomic_path(path) as temporary:
        pack(content, temporary)
    return path


def fmu_content(
    exported: Unit, stop_time: float, version: FmiVersion, clocked: bool = False
) -> dict[str, bytes]:
    """All files of an FMU, as :func:`write_fmu` packs them."""
    check(exported, stop_time)
    files = fmu_files(exported, stop_time, version, clocked)
    binary = f"{exported.prefix}{binary_ending()}"
    content = {name: text.encode() for name, text in files.items()}
    unprefixed = interface_of(version, exported.part).unprefixed
    content[f"binaries/{platform_folder(version)}/{binary}"] = built(files, binary, unprefixed)
    return content


def check_tools() -> None:
    """Find out before a long computation whether an FMU can be made here.

    Raises:
        HydroservoError: the package fmpy or a C compiler is missing.
    """
    package("fmpy")
    compiler()


def checked_ending(path: Path, ending: str = ".fmu") -> Path:
    """The path of an FMU, or of a system of them.

    Raises:
        HydroservoError: its ending is another.
    """
    if path.suffix.lower() != ending:
        raise HydroservoError(f"{path}: its name must end in {ending}")
    return path


def check(exported: Unit, stop_time: float) -> None:
    if exported.real != "double":
        raise ParameterError("precision", exported.real, "an FMU is in double precision")
    if exported.inlined:
        raise ParameterError("inlined", True, "an FMU has its parameters as variables; do not inline them")
    if not 0.0 < stop_time < math.inf:
        raise ParameterError("stop_time", stop_time, "must be positive and finite")


def built(files: Files, library: str, unprefixed: str) -> bytes:
    """The binary of the sources."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8", newline="\n")
        sources = folder / "sources"
        names = sorted(one.name for one in sources.glob("*.c"))
        words = [*AS_LIBRARY, f"-D{unprefixed}", "-Iinclude", *names]
        return compiled(sources, words, library).read_bytes()


def pack(content: Mapping[str, bytes], file: Path | BinaryIO) -> None:
    """A zip with these files, whose bytes depend on nothing else."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whose permissions follow
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content[name])
