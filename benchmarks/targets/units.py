"""The controllers that are measured: of each combination of blocks the first built-in scenario."""

from collections.abc import Iterator

import numpy as np

from benchmarks.targets.sources import Rows
from hydroservo import Loop
from hydroservo.block import Block, is_block
from hydroservo.export.exported import Exported
from hydroservo.export.units import Part, Precision, exported
from hydroservo.export.vectors import made_vectors
from hydroservo.scenario import builtin_scenarios, load_scenario

__all__ = ["controllers", "units"]

LARGEST = 1e100  # of an input that a loop gives


def controllers() -> dict[str, Loop]:
    """Loops by the names of their scenarios."""
    found: dict[tuple[type, ...], tuple[str, Loop]] = {}
    for name in builtin_scenarios():
        loop = load_scenario(name)
        found.setdefault(tuple(types(loop.controller)), (name, loop))
    return dict(found.values())


def types(block: Block) -> Iterator[type]:
    """The class of a block and of all in it."""
    yield type(block)
    for part in block:
        if is_block(part):
            yield from types(part)


def units(loops: dict[str, Loop]) -> Iterator[tuple[str, Exported, Rows]]:
    """Controllers in both precisions, with inputs that their loops give them."""
    for name, loop in loops.items():
        for precision in Precision:
            unit = exported(loop, Part.CONTROLLER, prefix="unit", title=name, precision=precision)
            inputs = made_vectors(loop, Part.CONTROLLER, unit).inputs
            yield name, unit, inputs[(np.abs(inputs) < LARGEST).all(axis=1)]
