"""Units in Structured Text, and their replay in Python."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.export.of_loop import exported_block
from hydroservo.export.st.project import replay_of
from hydroservo.export.st.source import STModule
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.export.vectors import Vectors, make_vectors
from hydroservo.testing.case import bits
from tests.support.export.st_machine import Machine


class Unit(NamedTuple):
    """A unit in Structured Text, the same in C, and its vectors."""

    c: CModule
    st: STModule
    vectors: Vectors

    @property
    def texts(self) -> list[str]:
        """Every type, function and function block."""
        return [*(one.text for one in self.st.structures), *(one.text for one in self.st.pous)]

    @property
    def replay(self) -> list[str]:
        """The texts of the block that replays the vectors."""
        return [one.text for one in replay_of(self.st, self.c, self.vectors)]


def unit_of(
    loop: Loop,
    part: Part = Part.CONTROLLER,
    precision: Precision = Precision.DOUBLE,
    inlined: bool = False,
) -> Unit:
    """What is exported of a loop."""
    c, st = exported_block(loop, part, prefix="unit", title="a unit", precision=precision, inlined=inlined)
    return Unit(c, st, make_vectors(loop, part, c))


def differences(unit: Unit) -> list[str]:
    """What the evaluator of Structured Text makes otherwise of the vectors than Python, to the last bit."""
    first = [[]] if unit.c.part is Part.DEMAND else []  # the start, which vectors begin after
    samples = list(evaluated(unit.st, [*first, *unit.vectors.inputs]))[len(first) :]
    rows = zip(samples, unit.vectors.expected.tolist(), strict=True)
    return [
        f"sample {i}: {place} is {number!r}, not {value!r}"
        for i, (numbers, wanted) in enumerate(rows)
        for place, number, value in zip(unit.st.states, numbers, wanted, strict=True)
        if bits(number) != bits(value) and not (math.isnan(number) and math.isnan(value))
    ]


def evaluated(st: STModule, inputs: Iterable[Sequence[float]]) -> Iterator[list[float]]:
    """The numbers of a block's state after each sample."""
    block = Machine([one.text for one in (*st.structures, *st.pous)]).block(st.block.name)
    for given in inputs:
        for name, value in zip(st.inputs, given, strict=True):
            block.set(name, float(value))
        block.call()
        yield [float(block.get(f"state.{place}")) for place in st.states]
