"""Least squares of samples that follow each other, and how sure what they find is."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.identification.long_run import long_run_covariance
from hydroservo.identification.uncertainty import NORMAL

Matrix = NDArray[np.float64]


class Regression(NamedTuple):
    """Coefficients and how sure they are.

    Attributes:
        values: shape (columns,).
        covariance: shape (columns, columns).
        scatter: the standard deviation of what is left.
    """

    values: Matrix
    covariance: Matrix
    scatter: float

    def ratio(self, above: Matrix, below: Matrix) -> tuple[float, float]:
        """A quotient of two sums of coefficients, and half of its 95 % interval.

        Args:
            above: the weights of the dividend, shape (columns,).
            below: those of the divisor.
        """
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

    Args:
        parts: of each stretch of time the columns, shape (n, columns), and what they explain, shape (n,).

    Source: Newey, West, Econometrica 55, 1987 (the covariance), with the lags of
    :func:`~hydroservo.identification.long_run.long_run_covariance`.
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


def mean_of(parts: Sequence[Matrix]) -> tuple[float, float, float]:
    """The mean of samples, their standard deviation, and half of the mean's 95 % interval.

    Args:
        parts: samples of one stretch of time each, shape (n,).
    """
    every = np.concatenate(parts)
    middle = float(every.mean())
    apart = [(one - middle)[:, np.newaxis] for one in parts if one.size > 1]
    spread = float(every.std(ddof=1)) if every.size > 1 else np.nan
    if not apart:
        return middle, spread, np.nan
    half = NORMAL * float(np.sqrt(max(long_run_covariance(apart)[0, 0], 0.0))) / every.size
    return middle, spread, half
