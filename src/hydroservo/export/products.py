"""What a loop becomes on its way to a target: a folder of C, an FMU, or a system of FMUs."""

from collections.abc import Callable, Iterable
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeVar

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.outputs import check_outputs, written_or_kept
from hydroservo.export.c.project import check_project, proven_vectors, write_c_project
from hydroservo.export.fmu import PARTS, check_clock, check_tools, checked_ending, write_fmu, write_ssp
from hydroservo.export.of_loop import exported_block, exported_unit
from hydroservo.export.st.names import unused_name
from hydroservo.export.st.project import check_st_project, checked_st_prefix, write_st_project
from hydroservo.export.texts import default_prefix
from hydroservo.export.unit import CModule, FmiVersion, Part, Precision, Proof
from hydroservo.export.vectors import Vectors
from hydroservo.runs.arguments import as_list, checked_loop, checked_path
from hydroservo.runs.fitting import name_with_inner

Progress = Callable[[float, str], None]  # called with the fraction done, and what is being done
Choice = TypeVar("Choice", bound=StrEnum)


class Export(NamedTuple):
    """A part of a loop that was exported.

    Attributes:
        unit: its C, and every number of it.
        proof: what was shown of it before it was written.
        files: those written.
    """

    unit: CModule
    proof: Proof
    files: tuple[Path, ...]

    def __repr__(self) -> str:
        folder = self.files[0].parent
        names = ", ".join(file.relative_to(folder).as_posix() for file in self.files)
        written = f"written to {folder}: {names}"
        return f"{self.unit.title}\n{proof_line(self.proof)}\n{written}"


def export_c(
    loop: Loop,
    folder: Path | str,
    *,
    part: str = Part.CONTROLLER,
    prefix: str | None = None,
    name: str = "",
    precision: str = Precision.DOUBLE,
    inlined: bool = False,
    progress: Progress | None = None,
) -> Export:
    """Write a part of a loop as C99, with test vectors, a program that replays them, a Makefile and a README.

    In double precision the C gives the bits of the strict simulation. Where this computer has a C compiler,
    the C is held against Python before it is written, on samples of the closed loop. Other files in the
    folder are left alone.

    Args:
        loop: the loop.
        folder: missing ones are made.
        part: "controller", with its observer and wrappers; "machine", from its command to its sensors;
            "equations", those of the machine, for other integrators; "demand"; or "loop", all of it.
        prefix: what names in C and files begin with, a C identifier; from the name if None.
        name: of the scenario, for the title and the prefix; the law's own if there is none.
        precision: "double", or "single" for a controller.
        inlined: the parameters are constants of the source; they are a record otherwise.
        progress: called now and then.

    Returns:
        What was exported, what was shown of it, and the paths of PREFIX.h, PREFIX.c, PREFIX_vectors.h,
        PREFIX_replay.c, Makefile and README.md.

    Raises:
        TranslationError: a block says what is not in the language; the message has file and line.
        ParameterError: a parameter is out of range, or an argument is not one of those above.
        LoopError: single precision where it cannot be, or the C is not what Python is.
        HydroservoError: a file cannot be written, or one of another origin is there under its name; what
            cannot be written for want of space is kept in a temporary folder, which the message names.

    Fails to prove anything of what these samples do not reach, and where there is no C compiler, as the proof
    says.
    """
    place, report = checked_path("folder", folder), progress or report_nothing
    loop = checked_loop(loop)
    wanted, digits = choose(Part, "part", part), choose(Precision, "precision", precision)
    check_project(place)  # before anything is computed; the names of the sources are known after it
    report(0.0, "translating")
    unit = translate_part(loop, wanted, name, prefix, digits, inlined)
    check_project(place, unit.prefix)
    return proven_folder(loop, unit, place, report, partial(write_c_project, unit))


def export_st(
    loop: Loop,
    folder: Path | str,
    *,
    part: str = Part.CONTROLLER,
    prefix: str | None = None,
    name: str = "",
    precision: str = Precision.DOUBLE,
    inlined: bool = False,
    progress: Progress | None = None,
) -> Export:
    """Write a controller or a demand as a function block in Structured Text (IEC 61131-3), with its replay.

    Writes plain text, PLCopen XML and TwinCAT files. C of the same functions is held against Python before
    anything is written, as by :func:`~hydroservo.export_c`; no PLC compiler runs. Other files in the folder
    are left alone, except TwinCAT files of an earlier export.

    Args:
        loop: the loop.
        folder: missing ones are made.
        part: "controller", with its observer and wrappers, or "demand".
        prefix: of all names, and the function block's own; from the name if None.
        name: as of :func:`~hydroservo.export_c`.
        precision: "double" (LREAL), or "single" (REAL) for a controller.
        inlined: the parameters are constants of the block; they are an input otherwise.
        progress: called now and then.

    Returns:
        The same unit in C, what was shown of it, and the paths of PREFIX.st, PREFIX.xml, their replays,
        README.md and the files of ``twincat``.

    Raises:
        TranslationError: as of :func:`~hydroservo.export_c`, and for a function without Structured Text.
        ParameterError: a parameter is out of range, or an argument is not one of those above.
        LoopError: single precision where it cannot be, or the C is not what Python is.
        HydroservoError: a file cannot be written, or one of another origin is there under its name.

    Source: IEC 61131-3, PLCopen TC6 XML 2.01.
    Fails to give the same bits on a controller that contracts a*b + c or has other numbers than those of
    IEEE 754, and to go on where a controller stops at a division by zero.
    """
    place, report = checked_path("folder", folder), progress or report_nothing
    loop = checked_loop(loop)
    wanted, digits = choose(Part, "part", part), choose(Precision, "precision", precision)
    check_st_project(place)
    report(0.0, "translating")
    title, own = title_and_prefix(loop, wanted, name)
    own = unused_name(own, set()) if prefix is None else checked_st_prefix(prefix)
    unit, module = exported_block(loop, wanted, prefix=own, title=title, precision=digits, inlined=inlined)
    check_st_project(place, [f"{own}.st", f"{own}.xml", f"{own}_replay.st", f"{own}_replay.xml"])
    return proven_folder(loop, unit, place, report, partial(write_st_project, unit, module))


def proven_folder(
    loop: Loop,
    unit: CModule,
    place: Path,
    report: Progress,
    write: Callable[[Vectors, Path, Proof], list[Path]],
) -> Export:
    """An export that is written to a folder, after its C has passed its test vectors."""
    vectors, proof = prove(loop, unit, 0.2, report)
    report(0.9, "writing files")
    return Export(unit, proof, tuple(written_or_kept(place, lambda to: write(vectors, to, proof))))


def export_fmu(
    loop: Loop,
    file: Path | str,
    *,
    part: str = Part.CONTROLLER,
    prefix: str | None = None,
    name: str = "",
    version: str = FmiVersion.FMI2,
    clocked: bool = False,
    platforms: Iterable[str] = (),
    progress: Progress | None = None,
) -> Export:
    """Write a part of a loop as a functional mock-up unit (FMU), with binaries and without Python.

    One of the machine's equations is for model exchange, others are for co-simulation, in steps of the sample
    period, or of any size with a clock. The C is held against Python before it is written, as by
    :func:`~hydroservo.export_c`.

    Args:
        loop: the loop; its duration is the end of the default experiment.
        file: ends in ".fmu".
        part: as of :func:`~hydroservo.export_c`.
        prefix: as there.
        name: as there.
        version: of FMI, "2" or "3".
        clocked: samples are the ticks of a clock; of a controller, in FMI 3.0.
        platforms: what it holds binaries for, by their names in FMI 3.0 such as "x86_64-linux"; that of this
            computer if there are none, others with a cross compiler.
        progress: called now and then.

    Returns:
        What was exported, what was shown of it, and the path written.

    Raises:
        TranslationError, ParameterError, LoopError, HydroservoError: as of :func:`~hydroservo.export_c`; also
            where the package fmpy or a C compiler is missing, a platform is none, or there can be no clock.

    Fails to run the binaries for other platforms.
    """
    path, report = checked_ending(checked_path("file", file)), progress or report_nothing
    loop = checked_loop(loop)
    wanted, fmi = choose(Part, "part", part), choose(FmiVersion, "version", version)
    check_outputs([path])
    if clocked:
        check_clock(fmi, wanted)
    built_for = check_tools(as_list("platforms", platforms, "names such as x86_64-linux"))
    report(0.0, "translating")
    unit = translate_part(loop, wanted, name, prefix)
    _, proof = prove(loop, unit, 0.2, report)
    report(0.9, "writing the FMU")
    duration = loop.simulation.duration

    def write(to: Path) -> list[Path]:
        place = to / path.name
        return [write_fmu(unit, place, version=fmi, stop_time=duration, clocked=clocked, platforms=built_for)]

    return Export(unit, proof, tuple(written_or_kept(path.parent, write)))


def export_ssp(
    loop: Loop,
    file: Path | str,
    *,
    name: str = "",
    version: str = FmiVersion.FMI2,
    platforms: Iterable[str] = (),
    progress: Progress | None = None,
) -> list[Export]:
    """Write a loop's controller, machine and demand as FMUs in one file, with how they are connected.

    A tool that asks for outputs in the order of their dependencies closes the loop as it is simulated. Each C
    is held against Python before it is written, as by :func:`~hydroservo.export_c`.

    Args:
        loop: the loop; its duration is the end of the default experiment.
        file: ends in ".ssp".
        name: as of :func:`~hydroservo.export_c`.
        version: as of :func:`~hydroservo.export_fmu`.
        platforms: as there.
        progress: called now and then.

    Returns:
        The controller, the machine and the demand, each with the path written.

    Raises:
        TranslationError, ParameterError, LoopError, HydroservoError: as of :func:`~hydroservo.export_fmu`.

    Source: SSP 1.0, https://ssp-standard.org.
    Fails to say in which order a tool shall ask, as :func:`~hydroservo.export.fmu.write_ssp` has it.
    """
    path, report = checked_ending(checked_path("file", file), ".ssp"), progress or report_nothing
    loop = checked_loop(loop)
    fmi = choose(FmiVersion, "version", version)
    check_outputs([path])
    built_for = check_tools(as_list("platforms", platforms, "names such as x86_64-linux"))
    report(0.0, "translating")
    units = {part: translate_part(loop, part, name, None) for part in PARTS}
    proofs = [prove(loop, units[part], 0.2 + 0.2 * i, report)[1] for i, part in enumerate(PARTS)]
    report(0.9, "writing the system")
    duration = loop.simulation.duration

    def write(to: Path) -> list[Path]:
        return [write_ssp(units, to / path.name, stop_time=duration, version=fmi, platforms=built_for)]

    files = tuple(written_or_kept(path.parent, write))
    return [Export(units[part], proof, files) for part, proof in zip(PARTS, proofs, strict=True)]


def translate_part(
    loop: Loop,
    part: Part,
    name: str,
    prefix: str | None,
    precision: Precision = Precision.DOUBLE,
    inlined: bool = False,
) -> CModule:
    """A part of a loop in C, with a title such as "TSMC of scenario paper/sine-tsmc"."""
    title, own = title_and_prefix(loop, part, name)
    return exported_unit(
        loop,
        part,
        prefix=own if prefix is None else prefix,
        title=title,
        precision=precision,
        inlined=inlined,
    )


def title_and_prefix(loop: Loop, part: Part, name: str) -> tuple[str, str]:
    """What a unit is called, and the prefix of its names where none is wished for."""
    if not isinstance(name, str):
        raise ParameterError("name", name, "must be a string: the name of a scenario")
    law = name_with_inner(loop.controller, "controller")
    what = law if part is Part.CONTROLLER else part.value.capitalize()
    return f"{what} of scenario {name}" if name else what, default_prefix(name or law, part)


def prove(loop: Loop, unit: CModule, done: float, report: Progress) -> tuple[Vectors, Proof]:
    """The test vectors of a unit, which its C has passed."""
    report(done, f"making test vectors of the {unit.part}, and replaying them")
    return proven_vectors(loop, unit.part, unit)


def choose(choices: type[Choice], argument: str, value: str) -> Choice:
    """The choice that a word stands for."""
    words = [choice.value for choice in choices]
    if value not in words:
        raise ParameterError(argument, value, one_of(str(value), words))
    return choices(value)


def report_nothing(done: float, what: str) -> None:
    """Report nothing."""


def proof_line(proof: Proof) -> str:
    """Whether the C passed its vectors here."""
    if proof.unproved:
        return f"not checked: {proof.unproved}"
    shown = proof.deviation.rpartition(": ")[2] or f"{proof.samples} samples bit for bit"
    return f"checked with {proof.compiler}: {shown}"
