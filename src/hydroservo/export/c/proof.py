"""Holds exported C against plain Python before it is written."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from hydroservo.errors import LoopError
from hydroservo.export.c.compiler import CompilerError, compiled, compiler, ran
from hydroservo.export.c.coverage import Branch, Coverage
from hydroservo.export.c.project import c_project
from hydroservo.export.c.trials import stretches
from hydroservo.export.c.vectors import Proof, Records, Tried, Vectors, input_row, replayed, tried, vectors_of
from hydroservo.export.unit import Part, Unit
from hydroservo.loop import Loop

__all__ = ["proven_vectors"]


def proven_vectors(loop: Loop, part: Part, unit: Unit) -> tuple[Vectors, Proof]:
    """Test vectors of an export that reach what can be reached of it, and that its C has passed here.

    They begin with those of the closed loop. As long as a branch of the blocks' methods is not reached, other
    stretches of samples are tried, and those kept that reach another one; in double precision alone, for they
    are far from anything that happens. The C is then compiled, and replays them.

    Args:
        loop: of the scenario.
        part: what of it is exported.
        unit: the export.

    Raises:
        LoopError: the C is not what Python is, or the compiler of this computer refuses it.
        ParameterError: the loop cannot be simulated.

    Fails to prove anything where there is no C compiler, and to count branches where there is no gcov; the
    proof of the vectors then says so.
    """
    trial = tried(loop, part, unit)
    branches: dict[Branch, bool] = {}
    uncounted = ""
    with TemporaryDirectory() as name:
        try:
            coverage = Coverage(unit, Path(name))
            branches, trial = searched(coverage, unit, trial)
        except CompilerError as error:
            uncounted = str(error)
    vectors = vectors_of(unit, trial)
    with TemporaryDirectory() as name:
        found, unproved = replay(unit, vectors, Path(name))
    missed = sorted({branch.line for branch, reached in branches.items() if not reached})
    counts = sum(branches.values()), len(branches), missed
    proof = Proof(len(vectors.expected), found, *counts, unproved, uncounted)
    return vectors._replace(proof=proof), proof


def searched(coverage: Coverage, unit: Unit, trial: Tried) -> tuple[dict[Branch, bool], Tried]:
    """The branches that are reached, and the samples that do so."""
    branches = coverage.branches(rows_of(unit, trial.inputs))
    if unit.real != "double":
        return branches, trial
    tries = list(stretches(trial.inputs))
    possible = coverage.branches(rows_of(unit, trial.inputs), [rows_of(unit, one) for one in tries])
    for stretch in tries:
        if sum(branches.values()) >= sum(possible.values()):
            break
        reached = coverage.branches(rows_of(unit, [*trial.inputs, *stretch]))
        if sum(reached.values()) == sum(branches.values()):
            continue
        try:
            states = replayed(trial.block, stretch, trial.states[-1])
        except LoopError:  # Python stops, and has no answer that C could be held against
            continue
        branches = reached
        inputs, states = [*trial.inputs, *stretch], [*trial.states, *states]
        trial = trial._replace(inputs=inputs, states=states, searched=trial.searched + 1)
    return branches, trial


def rows_of(unit: Unit, inputs: Sequence[Records]) -> np.ndarray:
    return np.array([input_row(unit, records) for records in inputs])


def replay(unit: Unit, vectors: Vectors, folder: Path) -> tuple[str, str]:
    """The compiler with which the vectors are replayed, bit for bit; or nothing, and why they are not.

    Raises:
        LoopError: a number differs, or the compiler works but refuses the C.
    """
    if unit.real != "double":
        return "", "numbers in single precision deviate; README.md says by how much"
    for name, text in c_project(unit, vectors).items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "nothing.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
    try:
        empty = compiled(folder, ["nothing.c"], "nothing")
        if ran(folder, [str(empty)]).returncode != 0:
            raise CompilerError("what the C compiler makes does not run here")
    except CompilerError as error:
        return "", str(error)
    try:
        program = compiled(folder, [f"{unit.prefix}_replay.c", f"{unit.prefix}.c"], "replay")
    except CompilerError as error:
        raise LoopError(f"nothing is written: {error}; {REPORT}") from error
    done = ran(folder, [str(program)])
    if done.returncode != 0:
        said = "; ".join(" ".join(line.split()) for line in done.stdout.splitlines())
        raise LoopError(f"nothing is written: the C is not what Python is: {said}; {REPORT}")
    return Path(compiler()[0]).name, ""


REPORT = "this is a fault of hydroservo's translation, please report it with the law"
