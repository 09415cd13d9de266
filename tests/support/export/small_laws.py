"""Laws whose step is a text, and their C held against plain Python."""

from pathlib import Path

import numpy as np

from hydroservo import Loop, Simulation
from hydroservo.core.signals import Demand, Measurement
from hydroservo.engine.compiling import compiled_function
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.scenario import load_plugin
from hydroservo.testing.case import bits
from hydroservo.testing.examples import example
from tools.targets.host import library

HEAD = '''\
"""A law of a test."""

import math
from typing import Annotated, NamedTuple

import numpy as np

from hydroservo import ops
from hydroservo.core.block import Field
from hydroservo.core.signals import Demand, Measurement

SLOPE = 2.5
slope = 7.5
TURNS = 4
ROOT = np.sqrt(2.0)
NAMES = ["u"]


def outside(x):
    return x


class Pair(NamedTuple):
    left: float
    right: float


class Ops(NamedTuple):
    x: float

    def sqrt(self):
        return self.x + 1.0


class Keyed(NamedTuple):
    double: float
    int: float


class Twice(NamedTuple):
    double: float
    double_: float


class LawState(NamedTuple):
    """A command, and a number beside it."""

    u: Annotated[float, Field("V", "command")]
    beside: Annotated[float, Field("V", "number beside it")]

    def total(self):
        return self.u + self.beside


class Law(NamedTuple):
    """A law of a test: u = ..."""

    gain: Annotated[float, Field("V s/m", "gain of the law", "this test")] = 3.0
    unused: Annotated[float, Field("V", "read by nobody", "this test")] = 7.0
    turns: Annotated[int, Field("", "whole number", "this test", at_least=1, at_most=9)] = 2
    reverse: bool = False

    def init(self):
        return LawState(0.0, 0.0)

    def pair(self, a, b):
        return a + b, a - b

    def counted(self, n):
        u = 0.0
        for _ in range(3):
            u = u + n
            n = n + 1
        return u

    def early(self, a, b):
        for i in range(4):
            if a > b + i:
                return a - 1.0 * i
            a = a + 0.5
        return b

    def turned(self, x):
        n = 0.0
        while x < 0.0:  # never ends
            n = n + 1.0
        return Pair(x, n - x)

    def many(self, *numbers):
        return numbers[0]

    def rooted(self, x):
        return ops.power(x, 0.5)

    def _hidden(self, x):
        return x + self.gain

    @property
    def half(self):
        return 0.5

    def step(self, s, y, r, dt):
'''
FIRST = HEAD.count("\n") + 1  # the line of the first statement
NAMED = {"prefix": "law", "title": "a law"}
Y = Measurement(0.25, 100.0, 0.03, 1.5, 2e6, 1e6, 0.0)
R = Demand(0.75, -2.0, 30.0)


def law(folder: Path, body: str, **changes: object) -> Loop:
    """A loop with a law whose step is this text."""
    return loop_of(folder, HEAD + "".join(f"        {line}\n" for line in body.splitlines()), **changes)


def loop_of(folder: Path, text: str, **changes: object) -> Loop:
    """A loop with the class Law of a file with this text."""
    file = folder / "law.py"
    file.write_text(text, encoding="utf-8")
    cls = next(one for one in load_plugin(file) if one.__name__ == "Law")
    return example(Loop, Simulation(1.0, 1e-3, record_period=1e-3), controller=cls(**changes))


def assert_same(loop: Loop, folder: Path, *, inlined: bool = False) -> None:
    """C and machine code give the bits of plain Python, for two steps."""
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED, inlined=inlined)
    numbers = dict(zip([f"measurement.{name}" for name in Y._fields], Y, strict=True))
    numbers |= dict(zip([f"demand.{name}" for name in R._fields], R, strict=True))
    row = [numbers[signal.path] for argument in unit.arguments for signal in argument.signals]
    found = library(unit, folder).run(np.array([row, row]))
    machine = compiled_function(type(loop.controller).step)
    state, expected = loop.controller.init(), []
    for _ in range(2):
        before, state = state, loop.controller.step(state, Y, R, 1e-3)
        expected.append([bits(float(x)) for x in state])
        assert [bits(float(x)) for x in machine(loop.controller, before, Y, R, 1e-3)] == expected[-1]
    assert [[bits(x) for x in row] for row in found.tolist()] == expected
