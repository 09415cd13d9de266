"""A method of some blocks at many arguments at once, in machine code."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block, values
from hydroservo.engine import flat
from hydroservo.engine.native import MachineCode, native_kernel
from hydroservo.engine.recipe import KernelKey

Numbers = NDArray[np.float64]


class CompiledRows:
    """What the method ``row`` of blocks of one shape returns, with the bits of plain Python.

    The blocks differ in their floats alone; ``given`` and ``returned`` are of the types that it takes and
    returns.
    """

    def __init__(self, blocks: Sequence[Block], given: Block, returned: Block) -> None:
        recipe = KernelKey("rows", tuple(map(flat.block_shape, (blocks[0], given, returned))), strict=True)
        self.call = native_kernel(recipe, lambda: compiled_rows(blocks[0], given, returned))
        self.width = len(values(returned))
        self.block = blocks[0]  # kept alive: the table of arrays points into it
        self.constants, self.tables = (
            np.array([*map(flat.block_numbers, blocks)]),
            flat.block_arrays(blocks[0]),
        )

    def __call__(self, rows: Numbers, which: NDArray[np.intp]) -> Numbers:
        """What some of the blocks return for rows of numbers of their own, shape (blocks, rows, numbers)."""
        given, out = np.require(rows, np.float64, ["C", "W"]), np.empty((*rows.shape[:2], self.width))
        self.call(self.constants[which], self.tables, given, out, *rows.shape[:2])
        return out


def compiled_rows(block: Block, given: Block, returned: Block) -> MachineCode:
    from hydroservo.engine.llvm.entries import DOUBLES, INTEGERS
    from hydroservo.engine.machine_code import machine_code
    from hydroservo.language.terms import INT

    build = flat.constructor("build(numbers, arrays, lane)", block, flat.leaf_positions(block, number_index))
    load, store = flat.loader(given, number_index), flat.storer(returned, number_index)
    width, taken, left = len(flat.block_numbers(block)), len(values(given)), len(values(returned))

    def rows(constants, tables, memory, out, blocks, count):  # type: ignore[no-untyped-def]
        for j in range(blocks):
            asked = build(constants, tables, j * width)
            for i in range(j * count, (j + 1) * count):
                store(out, i * left, asked.row(load(memory, i * taken)))
        return 0

    return machine_code(rows, (DOUBLES, INTEGERS, DOUBLES, DOUBLES, INT, INT), strict=True)


def number_index(i: int) -> str:
    """The index of the i-th number of a row that begins at ``lane``."""
    return f"{i} + lane"
