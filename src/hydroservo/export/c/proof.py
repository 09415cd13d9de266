"""Holds exported C against plain Python before it is written."""

from pathlib import Path

from hydroservo.errors import LoopError
from hydroservo.export.c.project import Proof, c_project
from hydroservo.export.c.vectors import Vectors, made_vectors
from hydroservo.export.compilers import CompilerError, compiled, compiler, ran
from hydroservo.export.unit import Part, Unit
from hydroservo.loop import Loop
from hydroservo.outputs import temporary_folder

DEVIATES = "numbers in single precision deviate; README.md says by how much"


def proven_vectors(loop: Loop, part: Part, unit: Unit) -> tuple[Vectors, Proof]:
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
    vectors = made_vectors(loop, part, unit)
    return vectors, proof_of(unit, vectors)


def proof_of(unit: Unit, vectors: Vectors) -> Proof:
    """What the C compiler of this computer shows of an export."""
    samples = len(vectors.expected)
    with temporary_folder() as folder:
        try:
            said = replay_output(unit, vectors, folder)
        except (CompilerError, LoopError) as error:
            if why := compiler_fault(folder):
                return Proof(samples, unproved=why)
            raise LoopError(f"nothing is written: {error}; {whose_fault()}") from None
    if unit.real != "double":
        return Proof(samples, unproved=DEVIATES, deviation=said)
    return Proof(samples, compiler=Path(compiler()[0]).name)


def replay_output(unit: Unit, vectors: Vectors, folder: Path) -> str:
    """What the replay of an export prints, whose numbers are those of the vectors in double precision."""
    for name, text in c_project(unit, vectors).items():
        (folder / name).write_text(text, encoding="utf-8")
    program = compiled(folder, [f"{unit.prefix}_replay.c", f"{unit.prefix}.c"], "try-replay")
    done = ran(folder, [str(program)])
    if done.returncode != 0 and (unit.real == "double" or not done.stdout):
        lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
        said = "; ".join(lines or [f"the replay ended with {done.returncode}"])
        raise LoopError(f"the C differs from Python: {said}")
    return done.stdout.strip()


def compiler_fault(folder: Path) -> str:
    """Why not even an empty program can be compiled and run here; empty if it can."""
    (folder / "try-compiler.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
    try:
        empty = compiled(folder, ["try-compiler.c"], "try-compiler")
        ends = ran(folder, [str(empty)]).returncode
    except CompilerError as error:
        return str(error)
    return "what the C compiler builds does not run here" if ends != 0 else ""


def whose_fault() -> str:
    """What to do about C that does not compile, or is not what Python is."""
    command = compiler()
    if len(command) > 1:
        return f"the environment's CC has options, {' '.join(command[1:])}: try without them"
    return "this is a fault of hydroservo's translation, please report it with the law"
