"""How much uncertainty a law survives."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


def survived(runs: "pd.DataFrame") -> float:
    """The largest scale of uncertainty at and below which no run was lost.

    Args:
        runs: of one law in one cell at one level, of the split ``stress``.

    Returns:
        A multiple of the nominal uncertainty; 0 where runs were lost at the smallest, nan where there are
        none.

    Fails: the largest scale that was tried is the most it can say.
    """
    if runs.empty:
        return np.nan
    lost = runs.groupby("scale")["lost"].any().sort_index()
    steps = int((~lost.to_numpy(np.bool_)).cumprod().sum())
    return float(lost.index[steps - 1]) if steps else 0.0
