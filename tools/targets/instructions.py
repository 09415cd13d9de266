"""The operations that are counted of controllers, held against the instructions that were measured."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo import Loop
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part

PAGE = Path(__file__).parents[2] / "docs" / "target.md"
TITLE = "### Instructions of a step"


class Shown(NamedTuple):
    """The instructions of a step, as the documentation shows them.

    Attributes:
        columns: processors and precisions.
        rows: by controller.
    """

    columns: Sequence[str]
    rows: Mapping[str, Sequence[float]]


class Compared(NamedTuple):
    """Operations against instructions, over controllers; one number for each processor and precision.

    Attributes:
        names: of the controllers.
        operations: of each, at most.
        ranks: Spearman's correlation.
        low, middle, high: quartiles of instructions for an operation.
    """

    names: Sequence[str]
    operations: NDArray[np.float64]
    ranks: Sequence[float]
    low: Sequence[float]
    middle: Sequence[float]
    high: Sequence[float]


def instructions_shown(page: str) -> Shown:
    """The table of instructions on the page of the target."""
    lines = page.partition(TITLE)[2].partition("###")[0].splitlines()
    table = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")]
    (columns, _, *rows) = table
    numbers = {name.strip("`"): [float(cell.replace(",", "")) for cell in cells] for name, *cells in rows}
    return Shown([one for one in re.split(r"\s*\|\s*", " | ".join(columns)) if one], numbers)


def compared(loops: Mapping[str, Loop], shown: Shown) -> Compared:
    """The operations of controllers against their instructions.

    Args:
        loops: of controllers, by the names that the page has.
        shown: what the page shows.
    """
    from scipy.stats import spearmanr

    names = [name for name in loops if name in shown.rows]
    units = [exported_unit(loops[name], Part.CONTROLLER, prefix="unit", title=name) for name in names]
    operations = np.array(
        [unit.operations.total if unit.operations else np.nan for unit in units], dtype=float
    )
    instructions = np.array([shown.rows[name] for name in names]).T
    quartiles = np.quantile(instructions / operations, [0.25, 0.5, 0.75], axis=1).tolist()
    ranks = [float(spearmanr(operations, column).statistic) for column in instructions]
    return Compared(names, operations, ranks, *quartiles)
