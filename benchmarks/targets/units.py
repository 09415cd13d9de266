"""Controllers in C, with inputs that their loops give them."""

from collections.abc import Iterator

import numpy as np

from hydroservo import Loop
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part, Precision
from hydroservo.export.vectors import make_vectors
from tools.targets.sources import Rows

__all__ = ["units"]

LARGEST = 1e100  # of an input that a loop gives


def units(loops: dict[str, Loop]) -> Iterator[tuple[str, CModule, Rows]]:
    """Controllers in both precisions, with inputs that their loops give them."""
    for name, loop in loops.items():
        for precision in Precision:
            unit = exported_unit(loop, Part.CONTROLLER, prefix="unit", title=name, precision=precision)
            inputs = make_vectors(loop, Part.CONTROLLER, unit).inputs
            yield name, unit, inputs[(np.abs(inputs) < LARGEST).all(axis=1)]
