"""A method of a block at many arguments at once, in machine code."""

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block, values
from hydroservo.engine import flat
from hydroservo.engine.native import MachineCode, native
from hydroservo.engine.recipe import Recipe

Numbers = NDArray[np.float64]


class CompiledRows:
    """What the method ``row`` of a block returns, with the bits of plain Python.

    Args:
        block: the block.
        given: what the method takes, a block, for its types.
        returned: what it returns, a block of floats, for its types.
    """

    def __init__(self, block: Block, given: Block, returned: Block) -> None:
        recipe = Recipe("rows", tuple(map(flat.shape, (block, given, returned))), strict=True)
        self.call = native(recipe, lambda: compiled_rows(block, given, returned))
        self.width = len(values(returned))
        self.block = block  # kept alive: the table of arrays points into it
        self.constants, self.tables = flat.numbers(block), flat.arrays(block)

    def __call__(self, rows: Numbers) -> Numbers:
        """What is returned for each row of numbers, as rows."""
        given, out = np.require(rows, np.float64, ["C", "W"]), np.empty((len(rows), self.width))
        self.call(self.constants, self.tables, given, out, len(rows))
        return out


def compiled_rows(block: Block, given: Block, returned: Block) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS
    from hydroservo.engine.machine_code import machine_code
    from hydroservo.language.terms import INT

    build, load, store = flat.builder(block), flat.loader(given, place), flat.storer(returned, place)
    taken, left = len(values(given)), len(values(returned))

    def rows(constants, tables, memory, out, count):  # type: ignore[no-untyped-def]
        asked = build(constants, tables)
        for i in range(count):
            store(out, i * left, asked.row(load(memory, i * taken)))
        return 0

    return machine_code(rows, (DOUBLES, INTEGERS, DOUBLES, DOUBLES, INT), strict=True)


def place(i: int) -> str:
    """The index of the i-th number of a row that begins at ``lane``."""
    return f"{i} + lane"
