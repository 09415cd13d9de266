"""How much uncertainty a law survives."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["survived"]


def survived(runs: "pd.DataFrame") -> float:
    """The largest scale of uncertainty at and below which no run was lost; median over searches.

    Args:
        runs: of one law in one cell, of the split ``stress``.

    Returns:
        A multiple of the nominal uncertainty; 0 where runs were lost at the smallest, nan where there are
        none.

    Fails: the largest scale that was tried is the most it can say.
    """
    if runs.empty:
        return np.nan
    lost = runs.groupby(["optimiser", "search_seed", "scale"], observed=True)["lost"].any().unstack("scale")
    scales = np.concatenate(([0.0], lost.columns.to_numpy(np.float64)))
    steps = (~lost.fillna(True).to_numpy(np.bool_)).cumprod(axis=1).sum(axis=1)
    return float(np.median(scales[steps]))
