"""The folder that an export in C is: the code, a replay of test vectors, what builds them, and a README."""

import re
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from hydroservo.errors import HydroservoError
from hydroservo.export.c.vectors import Vectors
from hydroservo.export.texts import rendered
from hydroservo.export.unit import Signal, Unit
from hydroservo.outputs import check_outputs, staged, write_text

TOLERANCE = "0.01"  # of a number's deviation in single precision, relative to its largest value
OURS = "Written by hydroservo"
OWN = re.compile(rf"{OURS}|\(scenario hash \w+, hydroservo ")  # the latter as vectors once began
FIRST_LINES = 8
SIZES = {"double": 8, "float": 4}  # bytes


class Proof(NamedTuple):
    """What was shown of an export when its vectors were made.

    Attributes:
        samples: of the vectors.
        compiler: with which the C replays the vectors, bit for bit; empty if it was not tried.
        unproved: why the C did not replay the vectors; empty if it did.
        deviation: of numbers in single precision, as the replay prints it; empty if it was not measured.
    """

    samples: int
    compiler: str = ""
    unproved: str = ""
    deviation: str = ""


class Memory(NamedTuple):
    """What an instance of an export takes of a target's memory."""

    state_bytes: int
    parameter_bytes: int


def memory(unit: Unit) -> Memory:
    """The sizes of the state and of the parameters, all of whose numbers are of one type."""
    size = SIZES[unit.real]
    parameters = 0 if unit.inlined else size * len(unit.parameters)
    return Memory(size * len(unit.states), parameters)


def write_c_project(
    unit: Unit, vectors: Vectors, folder: Path | str, proof: Proof | None = None
) -> list[Path]:
    """Write an export in C to a folder, and leave other files in it alone.

    Args:
        unit: what is exported.
        vectors: its test vectors.
        folder: missing ones are made.
        proof: what was shown of it; None says nothing of that.

    Returns:
        The paths of PREFIX.h, PREFIX.c, PREFIX_vectors.h, PREFIX_replay.c, Makefile and README.md.

    Raises:
        HydroservoError: a file cannot be written, or one of another origin is there under its name.
    """
    place = Path(folder)
    check_project(place, unit.prefix)
    with staged(place) as stage:
        for name, text in c_project(unit, vectors, proof).items():
            write_text(stage / name, text)
    return project_files(place, unit.prefix)


def project_files(folder: Path, prefix: str) -> list[Path]:
    """What :func:`write_c_project` writes into a folder."""
    sources = (f"{prefix}{ending}" for ending in (".h", ".c", "_vectors.h", "_replay.c"))
    return [folder / name for name in (*sources, "Makefile", "README.md")]


def check_project(folder: Path, prefix: str = "") -> None:
    """Refuse a folder that cannot be written to, or that has a file of another origin."""
    files = project_files(folder, prefix) if prefix else [folder / "Makefile", folder / "README.md"]
    check_outputs(files)
    for path in files:
        check_ours(path)


def check_ours(path: Path) -> None:
    """Refuse to replace a file that is not of an earlier export, as its first lines say."""
    try:
        if not path.exists():
            return
        with path.open(encoding="utf-8", errors="replace") as file:
            if any(OWN.search(line) for line in islice(file, FIRST_LINES)):
                return
    except OSError as error:
        raise HydroservoError(f"{path}: cannot be read: {error.strerror}") from None
    raise HydroservoError(f"{path}: not written by hydroservo, and not replaced; choose another folder")


def c_project(unit: Unit, vectors: Vectors, proof: Proof | None = None) -> dict[str, str]:
    """The texts of :func:`write_c_project` by file name."""
    p = unit.prefix
    known = {**names_in_c(unit), **numbers_in_c(unit, vectors), "x": unit, "proof": proof}
    return {
        f"{p}.h": unit.header,
        f"{p}.c": unit.source,
        f"{p}_vectors.h": rendered("vectors.h", known),
        f"{p}_replay.c": rendered("replay.c", known),
        "Makefile": rendered("Makefile", known),
        "README.md": rendered("README.md", known),
    }


def names_in_c(unit: Unit) -> dict[str, object]:
    """How the functions are called, and what the files are made of."""
    p = unit.prefix
    parameters = () if unit.inlined else (f"&{p}_defaults",)
    arguments = [f"&{argument.name}" for argument in unit.arguments]
    return {
        "PREFIX": p.upper(),
        "mark": f"{OURS} {unit.version}",
        "init": ", ".join(("&state", *parameters)),
        "step": ", ".join(("&state", *parameters, *arguments)),
        "unit": next((signal.unit for signal in unit.states if signal.place == "u"), ""),
        "reads_command": any(signal.path == "measurement.command" for signal in signals(unit)),
        "memory": memory(unit),
        "tolerance": TOLERANCE,
    }


def numbers_in_c(unit: Unit, vectors: Vectors) -> dict[str, object]:
    """The test vectors, and the places where they go."""
    return {
        "read": signals(unit),
        "places": [f"{one.name}.{signal.place}" for one in unit.arguments for signal in one.signals],
        "inputs": vectors.inputs.tolist(),
        "start": [signal.value for signal in unit.states],
        "expected": vectors.expected.tolist(),
        "samples": len(vectors.expected),
        "made": vectors.made,
    }


def signals(unit: Unit) -> list[Signal]:
    """What ``step`` reads of its arguments, in their order."""
    return [signal for argument in unit.arguments for signal in argument.signals]
