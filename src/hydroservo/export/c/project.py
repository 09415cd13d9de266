"""The folder that an export in C is, with a replay of test vectors, and its proof before it is written."""

from pathlib import Path
from typing import NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.errors import LoopError
from hydroservo.core.outputs import check_outputs, staged, temporary_folder, write_text
from hydroservo.export.compilers import CompilerError, compile_file, compiler, run_tool
from hydroservo.export.texts import OURS, check_ours, render
from hydroservo.export.unit import TOLERANCE, CModule, Part, Proof
from hydroservo.export.vectors import Vectors, make_vectors

SIZES = {"double": 8, "float": 4}  # bytes


class MemorySize(NamedTuple):
    """What an instance of an export takes of a target's memory."""

    state_bytes: int
    parameter_bytes: int


def memory_size(unit: CModule) -> MemorySize:
    """The sizes of the state and of the parameters, all of whose numbers are of one type."""
    size = SIZES[unit.real]
    parameters = 0 if unit.inlined else size * len(unit.parameters)
    return MemorySize(size * len(unit.states), parameters)


def write_c_project(
    unit: CModule, vectors: Vectors, folder: Path | str, proof: Proof | None = None
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


def c_project(unit: CModule, vectors: Vectors, proof: Proof | None = None) -> dict[str, str]:
    """The texts of :func:`write_c_project` by file name."""
    p = unit.prefix
    known = {**names_in_c(unit), **numbers_in_c(unit, vectors), "x": unit, "proof": proof}
    return {
        f"{p}.h": unit.header,
        f"{p}.c": unit.source,
        f"{p}_vectors.h": render("vectors.h", known),
        f"{p}_replay.c": render("replay.c", known),
        "Makefile": render("Makefile", known),
        "README.md": render("README.md", known),
    }


def names_in_c(unit: CModule) -> dict[str, object]:
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
        "reads_command": any(signal.path == "measurement.command" for signal in unit.inputs),
        "memory": memory_size(unit),
        "tolerance": TOLERANCE,
    }


def numbers_in_c(unit: CModule, vectors: Vectors) -> dict[str, object]:
    """The test vectors, and the places where they go."""
    return {
        "read": unit.inputs,
        "places": [f"{one.name}.{signal.place}" for one in unit.arguments for signal in one.signals],
        "inputs": vectors.inputs.tolist(),
        "start": [signal.value for signal in unit.states],
        "expected": vectors.expected.tolist(),
        "samples": len(vectors.expected),
        "made": vectors.made,
    }


def proven_vectors(loop: Loop, part: Part, unit: CModule) -> tuple[Vectors, Proof]:
    """Test vectors of an export, as of ``made_vectors``, that its C has passed here.

    Args:
        loop: of the scenario.
        part: what of it is exported.
        unit: the export.

    Raises:
        LoopError: the C is not what Python is, or the compiler of this computer refuses it.
        ParameterError: the loop cannot be simulated.

    Fails to prove anything of what these samples do not reach, and where there is no C compiler, as the proof
    then says.
    """
    vectors = make_vectors(loop, part, unit)
    return vectors, proof_of(unit, vectors)


def proof_of(unit: CModule, vectors: Vectors) -> Proof:
    """What the C compiler of this computer shows of an export.

    Raises:
        LoopError: the C does not compile, or its numbers are not those of the vectors.
    """
    samples = len(vectors.expected)
    with temporary_folder() as folder:
        try:
            said = replay_output(unit, vectors, folder)
        except (CompilerError, LoopError) as error:
            if why := compiler_fault(folder):
                return Proof(samples, unproved=why)
            raise LoopError(f"nothing is written: {error}; {whose_fault()}") from None
    return Proof(samples, Path(compiler()[0]).name, deviation="" if unit.real == "double" else said)


def replay_output(unit: CModule, vectors: Vectors, folder: Path) -> str:
    """What the replay of an export prints, whose numbers are those of the vectors in double precision."""
    for name, text in c_project(unit, vectors).items():
        (folder / name).write_text(text, encoding="utf-8")
    program = compile_file(folder, [f"{unit.prefix}_replay.c", f"{unit.prefix}.c"], "try-replay")
    done = run_tool(folder, [str(program)])
    if done.returncode != 0 and (unit.real == "double" or not done.stdout):
        lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
        said = "; ".join(lines or [f"the replay ended with {done.returncode}"])
        raise LoopError(f"the C differs from Python: {said}")
    return done.stdout.strip()


def compiler_fault(folder: Path) -> str:
    """Why not even an empty program can be compiled and run here; empty if it can."""
    (folder / "try-compiler.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
    try:
        empty = compile_file(folder, ["try-compiler.c"], "try-compiler")
        ends = run_tool(folder, [str(empty)]).returncode
    except CompilerError as error:
        return str(error)
    return "what the C compiler builds does not run here" if ends != 0 else ""


def whose_fault() -> str:
    """What to do about C that does not compile, or is not what Python is."""
    command = compiler()
    if len(command) > 1:
        return f"the environment's CC has options, {' '.join(command[1:])}: try without them"
    return "this is a fault of hydroservo's translation, please report it with the law"
