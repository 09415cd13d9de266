"""Holds exported C against plain Python before it is written."""

import math
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydroservo.errors import LoopError
from hydroservo.export.c.compiler import CompilerError, compiled, compiler, ran
from hydroservo.export.c.coverage import Branch, Coverage
from hydroservo.export.c.project import Proof, c_project
from hydroservo.export.c.vectors import (
    HUGE,
    Records,
    Trial,
    Vectors,
    input_rows,
    records_of,
    replayed,
    trial_of,
    vectors_of,
)
from hydroservo.export.unit import Part, Unit
from hydroservo.loop import Loop
from hydroservo.outputs import temporary_folder

MOST_FAILURES = 3  # of stretches that do not end

Rows = NDArray[np.float64]
BEYOND = (math.nan, math.inf, -math.inf, 1e308, 0.0)  # values of one number for one sample
FACTORS = (-1.0, 1e-9, 10.0, -10.0, 1e3, -1e3, 1e9)  # on a number's largest value, for a stretch
DRAWN = 30  # stretches of random numbers
SHORT, LONG = 50, 1000  # samples


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
    proof then says so.
    """
    trial = trial_of(loop, part, unit)
    branches: dict[Branch, bool] = {}
    uncounted = ""
    with temporary_folder() as folder:
        try:
            coverage = Coverage(unit, folder)
            branches = coverage.branches(input_rows(unit, trial.inputs))
        except CompilerError as error:
            uncounted = str(error)
        if unit.real == "double" and not all(branches.values()):
            branches, trial = search(coverage, unit, trial, branches)
    vectors = vectors_of(unit, trial)
    with temporary_folder() as folder:
        found, unproved = replay(unit, vectors, folder)
    missed = sorted(branch for branch, reached in branches.items() if not reached)
    methods = list(dict.fromkeys(unit.functions[branch.function] for branch in missed))
    counts = sum(branches.values()), len(branches), sorted({branch.line for branch in missed}), methods
    return vectors, Proof(len(vectors.expected), found, *counts, unproved, uncounted)


def search(
    coverage: Coverage, unit: Unit, trial: Trial, branches: dict[Branch, bool]
) -> tuple[dict[Branch, bool], Trial]:
    """The branches that are reached in the end, and the samples that do so.

    Each stretch goes on where those kept before it end. Nothing is searched where all of them together, each
    from the end of the closed loop, reach no other branch.
    """
    rows, failures = input_rows(unit, trial.inputs), 0
    tries = list(stretches(rows))
    with suppress(CompilerError):  # one stretch that does not end hides what the others reach
        if sum(coverage.branches(rows, tries).values()) == sum(branches.values()):
            return branches, trial
    for stretch in tries:
        longer = np.concatenate([rows, stretch])
        try:
            reached = coverage.branches(longer)
        except CompilerError:
            failures += 1
            if failures == MOST_FAILURES:
                break
            continue
        inputs = [records_of(unit, row, trial.inputs[-1]) for row in stretch]
        if sum(reached.values()) > sum(branches.values()) and (more := extended(trial, inputs)):
            rows, branches, trial = longer, reached, more
        if all(branches.values()):
            break
    return branches, trial


def extended(trial: Trial, inputs: list[Records]) -> Trial | None:
    """A trial that goes on with these inputs; None where Python stops, with nothing to hold C against."""
    try:
        states = replayed(trial.block, inputs, trial.states[-1])
    except LoopError:
        return None
    return trial._replace(
        inputs=[*trial.inputs, *inputs], states=[*trial.states, *states], stretches=trial.stretches + 1
    )


def replay(unit: Unit, vectors: Vectors, folder: Path) -> tuple[str, str]:
    """The compiler with which the vectors are replayed, bit for bit; or nothing, and why they are not."""
    for name, text in c_project(unit, vectors).items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "try-compiler.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
    try:
        empty = compiled(folder, ["try-compiler.c"], "try-compiler")
        if ran(folder, [str(empty)]).returncode != 0:
            raise CompilerError("what the C compiler builds does not run here")
    except CompilerError as error:
        return "", str(error)
    try:
        program = compiled(folder, [f"{unit.prefix}_replay.c", f"{unit.prefix}.c"], "try-replay")
        done = ran(folder, [str(program)])
    except CompilerError as error:
        raise LoopError(f"nothing is written: {error}; {whose_fault()}") from None
    if unit.real != "double":
        return "", "numbers in single precision deviate; README.md says by how much"
    if done.returncode != 0:
        lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
        said = "; ".join(lines or [f"the replay ended with {done.returncode}"])
        raise LoopError(f"nothing is written: the C differs from Python: {said}; {whose_fault()}")
    return Path(compiler()[0]).name, ""


def whose_fault() -> str:
    """What to do about C that does not compile, or is not what Python is."""
    command = compiler()
    if len(command) > 1:
        return f"the environment's CC has options, {' '.join(command[1:])}: try without them"
    return "this is a fault of hydroservo's translation, please report it with the law"


def stretches(inputs: Rows) -> Iterator[Rows]:
    """Samples in stretches, one number or all of them far from what the closed loop gave; the same each time.

    A number is in turn none, infinite, huge and 0 for one sample, then held at multiples of its largest
    value; then all are scaled, drawn evenly, and held for long. There are none where there are no inputs.

    Args:
        inputs: what the closed loop gave, shape (samples, numbers).

    Returns:
        Arrays of shape (10 to 1000, numbers).
    """
    if inputs.shape[1] == 0:
        return
    usual = np.where(np.abs(inputs) < HUGE, inputs, 0.0)
    largest = np.abs(usual).max(axis=0)
    largest[largest == 0.0] = 1.0
    last = usual[-SHORT:]
    for column in range(inputs.shape[1]):
        yield from of_one_number(last, largest, column)
    yield from of_all_numbers(last, largest)


def of_one_number(last: Rows, largest: Rows, column: int) -> Iterator[Rows]:
    for value in BEYOND:
        rows = last[-10:].copy()
        rows[len(rows) // 2, column] = value
        yield rows
    for factor in FACTORS:
        rows = last.copy()
        rows[:, column] = factor * largest[column]
        yield rows


def of_all_numbers(last: Rows, largest: Rows) -> Iterator[Rows]:
    draw = np.random.default_rng(1)
    for factor in FACTORS:
        yield factor * last
    for _ in range(DRAWN):
        yield 10.0 ** draw.uniform(-1.0, 2.0) * largest * draw.uniform(-1.0, 1.0, (SHORT, largest.size))
    for factor in FACTORS:
        yield np.tile(factor * largest, (LONG, 1))
