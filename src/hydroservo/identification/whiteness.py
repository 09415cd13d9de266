"""Whether residuals are noise, or hold what the model misses."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

LAGS = 20
CUT = 3.0  # deviations, to which residuals are cut, for single outliers are no sign of a model
DRAWS = 8  # of noise that is rounded as a signal is
COARSE = 0.5  # deviations of the residuals, from which a signal's resolution colours them

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


def whiteness(
    parts: Sequence[Samples], first: int = 1, null: Sequence[Sequence[Samples]] | None = None
) -> float:
    """The probability that noise alone would hang together as residuals do, or more: Ljung and Box's test.

    Args:
        parts: weighted residuals, of one stretch of time each; those of 20 samples or fewer are left out.
        first: lag that counts; later ones up to 20 do.
        null: residuals that noise alone leaves, where that is not white; they scale the statistic.

    Source: Ljung, Box, Biometrika 65, 1978, doi:10.1093/biomet/65.2.297.
    Fails to see what hangs together over more than 20 samples alone.
    """
    from scipy.special import chdtrc

    degrees = LAGS + 1 - first
    usual = max([portmanteau(one, first) for one in null or ()], default=0.0)
    return float(chdtrc(degrees, portmanteau(parts, first) * degrees / max(usual, degrees)))


def portmanteau(parts: Sequence[Samples], first: int) -> float:
    """Ljung and Box's statistic; 0 of too few residuals."""
    cut = [np.clip(part, -CUT, CUT) for part in parts if part.size > LAGS]
    size = sum(part.size for part in cut)
    if not size:
        return 0.0
    total = math.fsum(autocorrelation(cut, lag) ** 2 / (size - lag) for lag in range(first, LAGS + 1))
    return size * (size + 2.0) * total


def rounded_like(
    residuals: Sequence[Samples], measured: Sequence[Samples], step: float
) -> list[list[Samples]] | None:
    """Residuals that a right model leaves in a quantised signal; None where they are as good as white.

    What the model shows is taken for true, and noise is added to it of which, with the rounding, as much is
    left as of the residuals.

    Args:
        residuals: measured less simulated, weighted, of one stretch of time each.
        measured: in the same weight.
        step: of the signal's resolution, in the same weight; 0 where it has none.
    """
    if step <= COARSE:
        return None
    size = float(np.sqrt(np.mean(np.clip(np.concatenate(residuals), -CUT, CUT) ** 2)))
    noise = math.sqrt(max(size**2 - step**2 / 12.0, 0.0))
    rng = np.random.default_rng(0)
    draws = []
    for _ in range(DRAWS):
        shown = [values - left for values, left in zip(measured, residuals, strict=True)]
        noisy = [one + noise * rng.normal(size=one.size) for one in shown]
        draws.append([step * np.round(one / step) - own for one, own in zip(noisy, shown, strict=True)])
    return draws
