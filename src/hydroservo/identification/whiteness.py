"""Whether residuals are noise, or hold what the model misses."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["LAGS", "autocorrelation", "whiteness"]

LAGS = 20
CUT = 3.0  # deviations, to which residuals are cut, for single outliers are no sign of a model

Samples = NDArray[np.float64]


def autocorrelation(parts: Sequence[Samples], lag: int) -> float:
    """The correlation of residuals with themselves so many samples later; 0 for none.

    Args:
        parts: residuals of one stretch of time each.
        lag: in samples.
    """
    mean = float(np.mean(np.concatenate(parts)))
    after = math.fsum(float(((part[lag:] - mean) * (part[:-lag] - mean)).sum()) for part in parts)
    squares = math.fsum(float(((part - mean) ** 2).sum()) for part in parts)
    return after / squares if squares > 0.0 else 0.0


def whiteness(parts: Sequence[Samples]) -> float:
    """The probability that white noise would hang together as residuals do, or more: Ljung and Box's test.

    Args:
        parts: weighted residuals, of one stretch of time each; those of 20 samples or fewer are left out.

    Source: Ljung, Box, Biometrika 65, 1978, doi:10.1093/biomet/65.2.297.
    Fails to see what hangs together over more than 20 samples alone.
    """
    from scipy.stats import chi2

    cut = [np.clip(part, -CUT, CUT) for part in parts if part.size > LAGS]
    size = sum(part.size for part in cut)
    if not size:
        return 1.0
    total = math.fsum(autocorrelation(cut, lag) ** 2 / (size - lag) for lag in range(1, LAGS + 1))
    return float(chi2.sf(size * (size + 2.0) * total, LAGS))
