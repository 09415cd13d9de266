"""A file with an FMU for co-simulation: what it says of itself, read without running anything of it."""

import copyreg
import json
import math
import zipfile
import zlib
from functools import cache, lru_cache, partial
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import HydroservoError
from hydroservo.core.inputs import irregularity
from hydroservo.core.outputs import new_temporary_folder, temporary_folder

DESCRIPTION = "modelDescription.xml"
LARGEST = 1 << 30  # bytes of a file
MOST_UNPACKED, MOST_DESCRIBED, MOST_ENTRIES = 2 << 30, 64 << 20, 10_000  # bytes, bytes, files
REALS = ("Real", "Float64", "Float32")
UNREADABLE = (OSError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)  # of archives
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # units, as FMI has them
Parameter = tuple[float | bool | str, ...]  # one value, or those of an array


class FmuVariable(NamedTuple):
    """A variable of an FMU."""

    name: str  # in the FMU
    reference: int  # its value reference
    kind: str  # its type in FMI, such as "Float64"
    causality: str  # such as "input"
    settable: bool  # whether its start may be given before the initialization
    unit: str  # its unit as the FMU names it; "" where it names none
    in_base_units: str  # a factor times base units as text, "" where the FMU does not say
    factor: float  # that factor
    sizes: tuple[int, ...]  # of dimensions; -1 less the value reference of the parameter that has it
    start: int  # of a whole number, which may be an array's size; 0 of others

    @property
    def is_real(self) -> bool:
        return self.kind in REALS


class Fmu(NamedTuple):
    """What is known of an FMU."""

    path: Path  # the file
    digest: str  # SHA-256 of its content
    version: int  # of FMI, 2 or 3
    model: str  # the model's name
    identifier: str  # of the model in names of files
    token: str  # by which an instance is known to belong to the description
    binary: str  # the shared library for this machine, by its path in the archive
    single: bool  # whether a process can have but one instance
    internal_step: float  # the step that it takes inside [s]; nan where it does not say
    variables: dict[str, FmuVariable]  # by name


def read_fmu(path: Path) -> Fmu:
    """Read the description of an FMU."""
    return read_description(path, digest_of(path))


def digest_of(path: Path) -> str:
    """SHA-256 of a file's content."""
    if problem := irregularity(path, LARGEST):
        raise HydroservoError(problem)
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise HydroservoError(f"cannot be read: {(error.strerror or str(error)).lower()}") from None


@lru_cache(maxsize=64)
def read_description(path: Path, digest: str) -> Fmu:
    fmpy = fmpy_package()
    names, description = open_archive(path, fmpy)
    version, own = int(description.fmiVersion[0]), description.coSimulation
    if version not in (2, 3):
        raise HydroservoError(f"is an FMU of FMI {description.fmiVersion}; 2.0 and 3.0 can be run")
    if own is None:
        raise HydroservoError(
            "is an FMU for model exchange alone, which a loop cannot run; export it for co-simulation"
        )
    if own.needsExecutionTool:
        raise HydroservoError(
            "needs the tool that it was exported from while it runs; export it with its own solver"
        )
    return Fmu(
        path=path,
        digest=digest,
        version=version,
        model=description.modelName,
        identifier=own.modelIdentifier,
        token=description.guid,
        binary=binary_for_this_machine(names, version, own.modelIdentifier, fmpy),
        single=bool(own.canBeInstantiatedOnlyOncePerProcess),
        internal_step=own.fixedInternalStepSize or math.nan,
        variables={one.name: variable_of(one, description) for one in description.modelVariables},
    )


def open_archive(path: Path, fmpy: Any) -> tuple[list[str], Any]:
    """The names in an archive, and the description in it."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = {info.filename: info.file_size for info in archive.infolist()}
            unpacked_size, described = sum(entries.values()), entries.get(DESCRIPTION, 0)
            for holds, size, most, unit in (
                ("unpacks to", -(-unpacked_size >> 20), MOST_UNPACKED >> 20, "MiB"),
                ("has a description of", -(-described >> 20), MOST_DESCRIBED >> 20, "MiB"),
                ("holds", len(entries), MOST_ENTRIES, "files"),
            ):
                if size > most:
                    raise HydroservoError(f"{holds} {size} {unit}; at most {most} are read")
            text = b""
            if DESCRIPTION in entries:
                with archive.open(DESCRIPTION) as entry:
                    text = entry.read(MOST_DESCRIBED)  # in pieces: the size that it declares may be wrong
    except UNREADABLE:
        raise HydroservoError("is not an FMU: it cannot be read as a zip archive") from None
    if not text:
        raise HydroservoError(f"is not an FMU: it has no {DESCRIPTION}")
    with temporary_folder() as folder:
        file = folder / DESCRIPTION
        file.write_bytes(text)
        try:
            return list(entries), fmpy.read_model_description(str(file), validate=False)
        except Exception as error:  # whatever FMPy and lxml raise for a text that is not as it should be
            raise HydroservoError(f"has a {DESCRIPTION} that cannot be read: {error}") from None


def fmpy_package() -> Any:
    try:
        import fmpy
    except ImportError:
        raise HydroservoError("needs the package fmpy: pip install '.[fmu]' in a clone") from None
    return fmpy


def binary_for_this_machine(names: list[str], version: int, identifier: str, fmpy: Any) -> str:
    """The shared library for this machine, in an archive."""
    folders = [fmpy.platform_tuple] if version == 3 else [fmpy.platform_tuple, fmpy.platform]
    for folder in folders:
        binary = f"binaries/{folder}/{identifier}{fmpy.sharedLibraryExtension}"
        if binary in names:
            return binary
    there = sorted({name.split("/")[1] for name in names if name.startswith("binaries/") and name[9:]})
    found = f"those in it are for {', '.join(there)}" if there else "there is none in it"
    raise HydroservoError(f"has no binary for this machine, {folders[-1]}; {found}")


def variable_of(one: Any, description: Any) -> FmuVariable:
    unit = one.unit or (one.declaredType.unit if one.declaredType is not None else "") or ""
    base = next((known.baseUnit for known in description.unitDefinitions if known.name == unit), None)
    in_base_units, factor = unit_in_base_units(base)
    return FmuVariable(
        name=one.name,
        reference=one.valueReference,
        kind=one.type,
        causality=one.causality,
        settable=one.variability != "constant" and one.initial in ("exact", "approx"),
        unit=unit,
        in_base_units=in_base_units,
        factor=factor,
        sizes=tuple(
            -1 - int(side.valueReference) if side.start is None else int(side.start)
            for side in one.dimensions
        ),
        start=int(one.start) if one.type.startswith(("Int", "UInt")) and one.start else 0,
    )


def unit_in_base_units(unit: Any) -> tuple[str, float]:
    """A unit as FMPy has it in base units: a product of their powers, "1" of none, and the factor before it.

    Of no unit, or one with an offset, that is "" and 1.
    """
    if unit is None or unit.offset:
        return "", 1.0
    powers = [f"{name}^{power}" for name in BASE if (power := int(getattr(unit, name) or 0))]
    return " ".join(powers) or "1", float(unit.factor)


@lru_cache(maxsize=64)
def unpacked_folder(path: Path, digest: str) -> Path:
    """A folder with the files of an FMU, which goes when the process ends."""
    if digest_of(path) != digest:
        raise HydroservoError(f"{path}: has changed since it was read")
    folder = new_temporary_folder()
    fmpy_package().extract(str(path), unzipdir=str(folder))
    return folder


class Wire(NamedTuple):
    """A signal of the loop and the variable that stands for it."""

    signal: str  # such as "position"
    variable: str  # the name of the FMU's variable
    element: int  # which of an array's, from 0
    factor: float  # SI units per unit of the variable


class Foreign(NamedTuple):
    """An FMU, its wires and its parameters."""

    fmu: Fmu  # what is known of the file
    inputs: tuple[Wire, ...]  # what it is given at each communication
    outputs: tuple[Wire, ...]  # what it answers
    parameters: tuple[tuple[str, Parameter], ...]  # set before its initialization, in its own units

    @property
    def name(self) -> str:
        """What messages call it."""
        return self.fmu.path.name

    def digest(self) -> str:
        """Differs where content, wires or parameters do."""
        text = json.dumps([self.fmu.digest, self.inputs, self.outputs, self.parameters])
        return sha256(text.encode()).hexdigest()[:12]


def fmu_block_class(base: type, foreign: Foreign) -> type[Any]:
    """A class of blocks that have this FMU as their ``foreign``.

    Its module's name holds the digest, as that of a plug-in's does: results and hashes tell it from others.
    """
    return cached_block_class(base, str(foreign.fmu.path), foreign.fmu.digest, *foreign[1:])


@cache
def cached_block_class(base: type, path: str, content: str, *use: Any) -> type[Any]:
    """The one class of an FMU put to use in one way."""
    fmu = read_fmu(Path(path))
    if fmu.digest != content:
        raise HydroservoError(f"{path}: has changed since it was read")
    foreign = Foreign(fmu, *use)
    members = {"foreign": foreign, "__slots__": (), "__doc__": base.__doc__}
    cls = type("FMU", (base,), {**members, "__module__": f"fmu_{foreign.digest()}"})
    copyreg.pickle(cls, partial(reduce_fmu_block, (base, path, content, *use)))
    return cls


def reduce_fmu_block(use: tuple[Any, ...], block: Any) -> tuple[Any, ...]:
    """What pickle keeps of a block: how to make it again in another process."""
    return restore_fmu_block, (use, tuple(block))


def restore_fmu_block(use: tuple[Any, ...], values: tuple[Any, ...]) -> Any:
    """A block from its pickle; as with any pickle, load only what you trust."""
    return cached_block_class(*use)._make(values)
