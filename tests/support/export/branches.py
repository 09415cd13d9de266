"""Samples that reach more branches of an export's C than the closed loop does, as gcov counts them."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, leaves, replace
from hydroservo.core.errors import LoopError
from hydroservo.export.of_loop import TAKES
from hydroservo.export.parts import block_of, with_its_substeps
from hydroservo.export.unit import CModule, Part
from hydroservo.export.vectors import HUGE, Records, Vectors, make_vectors, replay_states, rows_at
from hydroservo.language.names import place_in_c
from hydroservo.runs.run import runnable_loop
from tests.support.needs import needs
from tools.targets.compilers import output
from tools.targets.host import Program, program
from tools.targets.sources import Rows

COUNTED = ("-O0", "--coverage")  # without optimization a branch of the text is one of the program
NO_METHODS = ("ops_", "parts_infinite")  # what functions begin with that are no methods of blocks
BEYOND = (math.nan, math.inf, -math.inf, 1e308, 0.0)  # values of one number for one sample
FACTORS = (-1.0, 1e-9, 10.0, -10.0, 1e3, -1e3, 1e9)  # on a number's largest value, for a stretch
DRAWN = 30  # stretches of random numbers
SHORT, LONG = 50, 1000  # samples


class Branch(NamedTuple):
    """One way on from a condition."""

    line: int  # of the source
    way: int


class Found(NamedTuple):
    """Test vectors, and whether they reach each branch of the blocks' methods."""

    vectors: Vectors
    branches: dict[Branch, bool]

    @property
    def missed(self) -> list[int]:
        """The lines with a branch that is not reached."""
        return sorted({branch.line for branch, reached in self.branches.items() if not reached})


def searched(loop: Loop, part: Part, unit: CModule, folder: Path) -> Found:
    """The vectors of an export, and after them stretches of samples that reach another branch each.

    Each stretch goes on where those kept before it end; one on which Python stops is left out.
    """
    needs("gcc", "gcov")
    counting = program(unit, folder, "gcc", COUNTED)
    block = block_of(with_its_substeps(runnable_loop(loop)), part)
    vectors = make_vectors(loop, part, unit)
    branches = reached(counting, vectors.inputs)
    for stretch in stretches(vectors.inputs):
        if all(branches.values()):
            break
        rows = np.concatenate([vectors.inputs, stretch])
        more = reached(counting, rows)
        if sum(more.values()) > sum(branches.values()) and (states := states_of(block, part, unit, rows)):
            expected = rows_at(states, [signal.place for signal in unit.states])
            vectors, branches = vectors._replace(inputs=rows, expected=expected), more
    return Found(vectors, branches)


def reached(counting: Program, rows: Rows) -> dict[Branch, bool]:
    """Each branch of the blocks' methods, and whether these samples reach it, from ``init`` on."""
    counts = counting.path.parent / f"{counting.unit.prefix}.gcda"
    counts.unlink(missing_ok=True)
    counting.run(rows)
    said = output(["gcov", "--json-format", "--branch-probabilities", "--stdout", counts])
    (file,) = (one for one in json.loads(said)["files"] if one["file"].endswith(f"/{counting.unit.prefix}.c"))
    return {
        Branch(line["line_number"], way): branch["count"] > 0
        for line in file["lines"]
        if not line.get("function_name", "ops_").startswith(NO_METHODS)
        for way, branch in enumerate(line["branches"])
    }


def states_of(block: Block, part: Part, unit: CModule, rows: Rows) -> list[Block]:
    """A block's state in plain Python after each row; none where Python stops."""
    try:
        return replay_states(block, [records_of(part, unit, row) for row in rows])
    except LoopError:
        return []


def records_of(part: Part, unit: CModule, row: Rows) -> Records:
    """The arguments of a step that reads this row; what it does not read is 0."""
    numbers = iter(row.tolist())
    records = {name: cls(*[0.0] * len(cls._fields)) for name, cls in TAKES[part]}
    for argument in unit.arguments:
        paths = {place_in_c(path): path for path, _ in leaves(records[argument.name])}
        changes = {paths[signal.place]: next(numbers) for signal in argument.signals}
        records[argument.name] = replace(records[argument.name], changes)
    return records


def stretches(inputs: Rows) -> Iterator[Rows]:
    """Samples in stretches, one number or all of them far from what the closed loop gave; the same each time.

    A number is in turn none, infinite, huge and 0 for one sample, then held at multiples of its largest
    value; then all are scaled, drawn evenly, and held for long. There are none where there are no inputs.
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
