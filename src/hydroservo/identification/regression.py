"""Least squares of samples that follow each other, and how sure what they find is."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MOST_CORRELATED = 0.97  # autocorrelation that is taken out before; beyond, too few samples are independent

Matrix = NDArray[np.float64]
LONGEST = 4000  # samples of a stretch that count; of more, means are taken over several

Samples = NDArray[np.float64]
NORMAL = 1.96  # deviations, to the ends of a 95 % interval


def long_run_covariance(parts: Sequence[Matrix]) -> Matrix:
    """The covariance of the sum of rows, with their autocorrelation taken into account::

        B = sum over lags l of w(l) sum over k of s_k s_(k+l)'

    What follows from one row to the next in proportion is taken out of each column before and put back after,
    and the rest counts with Bartlett's weights w up to a number of lags that its own autocorrelation says.

    Each part is of one stretch of time, shape (n, numbers); nothing is known between two.

    Source: Andrews, Monahan, Econometrica 60, 1992, doi:10.2307/2951574 (what is taken out before);
    Andrews, Econometrica 59, 1991, doi:10.2307/2938229, eqs. (6.2)-(6.4) (the number of lags).
    Fails where rows hang together over a large part of a stretch.
    """
    follows = np.clip(autocorrelations(parts), -MOST_CORRELATED, MOST_CORRELATED)
    rest = [part[1:] - follows * part[:-1] for part in parts]
    lags = lag_count(rest)
    total = sum((bartlett_sum(one, lags) for one in rest), np.zeros((follows.size, follows.size)))
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


def lag_count(parts: Sequence[Matrix]) -> int:
    """How many lags count: Andrews' rule for Bartlett's weights, each column with the weight of its size."""
    rho = np.clip(autocorrelations(parts), -MOST_CORRELATED, MOST_CORRELATED)
    rows = sum(len(part) for part in parts)
    there = np.array(sum((part**2).sum(axis=0) for part in parts)) > 0.0
    r = rho[there]
    if not r.size:
        return 0
    alpha = float(np.mean(4.0 * r**2 / ((1.0 - r) ** 6 * (1.0 + r) ** 2)) / np.mean(1.0 / (1.0 - r) ** 4))
    return min(int(1.1447 * math.cbrt(alpha * rows)), rows // 10)


def bartlett_sum(rows: Matrix, lags: int) -> Matrix:
    """The weighted sum over lags."""
    total: Matrix = rows.T @ rows
    for lag in range(1, min(lags, len(rows) - 1) + 1):
        one = rows[lag:].T @ rows[:-lag]
        total += (1.0 - lag / (lags + 1.0)) * (one + one.T)
    return total


def thin_out(
    period: float, rows: Mapping[str, Samples], most: int = LONGEST
) -> tuple[float, dict[str, Samples]]:
    """Signals as means over so many samples each that few are left, and the time between these."""
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


class Regression(NamedTuple):
    """Coefficients and how sure they are."""

    values: Matrix  # shape (columns,)
    covariance: Matrix  # shape (columns, columns)
    scatter: float  # the standard deviation of what is left

    def ratio(self, above: Matrix, below: Matrix) -> tuple[float, float]:
        """A quotient of two sums of coefficients, and half of its 95 % interval."""
        top, bottom = float(above @ self.values), float(below @ self.values)
        slope = (above - below * (top / bottom)) / bottom
        return top / bottom, self.half(slope)

    def without(self, place: int) -> "Regression":
        """The coefficients that go best with 0 in place of one of them; their covariance stays as it is."""
        share = self.covariance[:, place] / self.covariance[place, place]
        values = self.values - share * self.values[place]
        values[place] = 0.0
        return self._replace(values=values)

    def half(self, weights: Matrix) -> float:
        """Half of the 95 % interval of a sum of coefficients with these weights."""
        return float(NORMAL * np.sqrt(max(float(weights @ self.covariance @ weights), 0.0)))


def regression(parts: Sequence[tuple[Matrix, Matrix]]) -> Regression | None:
    """What columns explain of rows, by least squares; None where they cannot be told apart.

    The covariance takes into account that what is left hangs together over time.

    A part is one stretch of time: columns of shape (n, columns), and what they explain.

    Source: Newey, West, Econometrica 55, 1987 (the covariance), with the lags of
    :func:`~hydroservo.identification.regression.long_run_covariance`.
    Fails where columns are as noisy as what they explain: they then count for too little.
    """
    design = np.concatenate([one for one, _ in parts])
    aim = np.concatenate([y for _, y in parts])
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300) if len(design) else np.ones(design.shape[1])
    if len(design) <= design.shape[1]:
        return None
    found, _, rank, _ = np.linalg.lstsq(design / scale, aim, rcond=1e-9)
    if rank < design.shape[1]:
        return None
    scores = [one / scale * (y - one / scale @ found)[:, np.newaxis] for one, y in parts if len(one) > 1]
    inverse = np.linalg.inv((design / scale).T @ (design / scale))
    covariance = inverse @ long_run_covariance(scores) @ inverse / np.outer(scale, scale)
    left = aim - design / scale @ found
    freedom = len(design) - design.shape[1]
    return Regression(found / scale, covariance, float(np.sqrt(left @ left / freedom)))


def mean_with_interval(parts: Sequence[Matrix]) -> tuple[float, float, float]:
    """The mean of samples, their standard deviation, and half of the mean's 95 % interval."""
    every = np.concatenate(parts)
    middle = float(every.mean())
    apart = [(one - middle)[:, np.newaxis] for one in parts if one.size > 1]
    spread = float(every.std(ddof=1)) if every.size > 1 else np.nan
    if not apart:
        return middle, spread, np.nan
    half = NORMAL * float(np.sqrt(max(long_run_covariance(apart)[0, 0], 0.0))) / every.size
    return middle, spread, half
