"""Inputs that no sensor should give, mixed with ones that it does, and what a controller makes of them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tools.targets.host import Library, Program
from tools.targets.sources import Rows

SPECIAL = (
    *(np.nan, np.inf, -np.inf),
    *(1e308, -1e308, 1e38, -1e38, 1e19, -1e19),
    *(5e-324, -5e-324, 2.2e-308, 1e-40, 0.0, -0.0),
)
BLOCK = 100  # rows from one start to the next: half of them with such inputs, half without any


class Verdict(NamedTuple):
    """Of the commands of one run.

    Attributes:
        outside: how many are beyond the limits; infinities are, NaN is not.
        not_numbers: how many are NaN.
        lost: in how many blocks the command is still not a number after half a block of ordinary rows.
    """

    outside: int
    not_numbers: int
    lost: int


def fuzzed(normal: Rows, seed: int, share: float = 0.05) -> NDArray[np.float64]:
    """Ordinary rows, with this share of the numbers in the first half of each block replaced."""
    random = np.random.default_rng(seed)
    first = np.arange(len(normal)) % BLOCK < BLOCK // 2
    replaced = (random.random(normal.shape) < share) & first[:, np.newaxis]
    return np.where(replaced, random.choice(SPECIAL, normal.shape), normal)


def verdict(unit: Program | Library, normal: Rows, limit: float, seed: int = 0) -> Verdict:
    """What a controller commands after such inputs; its largest command is known to the caller.

    Raises:
        ToolError: a sanitizer stopped the program.
    """
    places = [signal.place for signal in unit.unit.states]
    command = unit.run(fuzzed(normal, seed), restart=BLOCK)[:, places.index("u")]
    last = command[BLOCK - 1 :: BLOCK]
    return Verdict(
        int(np.sum(np.abs(command) > limit)), int(np.sum(np.isnan(command))), int(np.sum(np.isnan(last)))
    )
