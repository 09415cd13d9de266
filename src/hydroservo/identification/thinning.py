"""Many samples as fewer means."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

MOST = 4000  # samples of a stretch that count; of more, means are taken over several

Samples = NDArray[np.float64]


def thinned(period: float, rows: Mapping[str, Samples], most: int = MOST) -> tuple[float, dict[str, Samples]]:
    """Signals as means over so many samples each that few are left, and the time between these.

    Args:
        period: between samples [s].
        rows: by name, shape (n,); nan where nothing was measured.
        most: that may be left.
    """
    size = next(iter(rows.values())).size
    width = -(-size // most)
    ends = [*range(0, size - width + 1, width)]
    found = {name: np.full(len(ends), np.nan) for name in rows}
    for name, values in rows.items():
        blocks = values[: len(ends) * width].reshape(len(ends), width)
        there = np.isfinite(blocks)
        counts = there.sum(axis=1)
        sums = np.where(there, blocks, 0.0).sum(axis=1)
        found[name] = np.divide(sums, counts, out=found[name], where=counts > 0)
    return width * period, found
