"""The covariance of a sum of numbers that follow each other and may hang together."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

MOST = 0.97  # autocorrelation that is taken out before; beyond, too few samples are independent

Matrix = NDArray[np.float64]


def long_run_covariance(parts: Sequence[Matrix]) -> Matrix:
    """The covariance of the sum of rows, with their autocorrelation taken into account::

        B = sum over lags l of w(l) sum over k of s_k s_(k+l)'

    What follows from one row to the next in proportion is taken out of each column before and put back after,
    and the rest counts with Bartlett's weights w up to a number of lags that its own autocorrelation says.

    Args:
        parts: rows of shape (n, numbers) of one stretch of time each, nothing being known between two.

    Source: Andrews, Monahan, Econometrica 60, 1992, doi:10.2307/2951574 (what is taken out before);
    Andrews, Econometrica 59, 1991, doi:10.2307/2938229, eqs. (6.2)-(6.4) (the number of lags).
    Fails where rows hang together over a large part of a stretch.
    """
    follows = np.clip(autocorrelations(parts), -MOST, MOST)
    rest = [part[1:] - follows * part[:-1] for part in parts]
    total = sum((bartlett(one, lags(rest)) for one in rest), np.zeros((follows.size, follows.size)))
    back = 1.0 / (1.0 - follows)
    scale = sum(len(part) for part in parts) / sum(len(one) for one in rest)
    found: Matrix = scale * total * back[:, np.newaxis] * back
    return found


def autocorrelations(parts: Sequence[Matrix]) -> Matrix:
    """The correlation of each column with itself a row later; 0 for one that is 0."""
    after = sum((part[1:] * part[:-1]).sum(axis=0) for part in parts)
    squares = sum((part[:-1] ** 2).sum(axis=0) for part in parts)
    found: Matrix = np.divide(after, squares, out=np.zeros_like(squares), where=squares > 0.0)
    return found


def lags(parts: Sequence[Matrix]) -> int:
    """How many lags count: Andrews' rule for Bartlett's weights, each column with the weight of its size."""
    rho = np.clip(autocorrelations(parts), -MOST, MOST)
    rows = sum(len(part) for part in parts)
    there = np.array(sum((part**2).sum(axis=0) for part in parts)) > 0.0
    r = rho[there]
    if not r.size:
        return 0
    alpha = float(np.mean(4.0 * r**2 / ((1.0 - r) ** 6 * (1.0 + r) ** 2)) / np.mean(1.0 / (1.0 - r) ** 4))
    return min(int(1.1447 * math.cbrt(alpha * rows)), rows // 10)


def bartlett(rows: Matrix, lags: int) -> Matrix:
    """The weighted sum over lags."""
    total: Matrix = rows.T @ rows
    for lag in range(1, min(lags, len(rows) - 1) + 1):
        one = rows[lag:].T @ rows[:-lag]
        total += (1.0 - lag / (lags + 1.0)) * (one + one.T)
    return total
