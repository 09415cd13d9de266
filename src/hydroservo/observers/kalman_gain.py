"""Steady-state Kalman gains of the nominal model, computed before a run."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydroservo.block import Block
from hydroservo.errors import ParameterError
from hydroservo.plants.design_model import DesignModel

__all__ = ["rates_of", "steady_gain"]

Matrix = NDArray[np.float64]

DIGITS = 9  # of a gain: LAPACK's last ones differ from processor to processor, by some 1e-13


def rates_of(model: DesignModel) -> Matrix:
    """d/dt of [x1, x2, d_L1, d_L2] at rest, shape (4, 4)."""
    rates = np.zeros((4, 4))
    rates[0] = [model.f1(1.0), model.g1(), 1.0, 0.0]
    rates[1] = [model.f2(1.0, 0.0), model.f2(0.0, 1.0), 0.0, 1.0]
    return rates


def steady_gain(
    observer: Block, rates: Matrix, seen: Sequence[int], sizes: Sequence[float], period: float
) -> Matrix:
    """The gain L with which measurements correct the states, from the discrete algebraic Riccati equation.

    Args:
        observer: the filter; its first four fields are q1 and q2, the intensity of each walk per root second,
            and r1 and r2, the rms of each measurement's noise per sample.
        rates: d/dt of the n states, the last two of which walk at random.
        seen: numbers of the two states that are measured.
        sizes: what the first n - 2 states are scaled by, so that SI numbers of any size go together.
        period: sample period [s].

    Returns:
        Shape (n, 2), in nine digits: LAPACK's last ones are others on another processor, and a run is to have
        the same bits there.

    Raises:
        ParameterError: there is no steady state, or it is out of the reach of floating-point numbers.
    """
    from scipy.linalg import solve_discrete_are

    walks, noise = np.array(observer[:2]), np.array(observer[2:4])
    size = len(rates)
    scale = np.concatenate([sizes, walks * math.sqrt(period)])
    with np.errstate(all="ignore"):
        try:
            measured = np.eye(size)[list(seen)] * scale / noise[:, np.newaxis]
            transition, added = sampled(rates * scale / scale[:, np.newaxis], period)
            spread = solve_discrete_are(transition.T, measured.T, added, np.eye(2))
            gain: Matrix = spread @ measured.T @ np.linalg.inv(measured @ spread @ measured.T + np.eye(2))
            gain = gain * scale[:, np.newaxis] / noise
        except (np.linalg.LinAlgError, ValueError):
            gain = np.full((size, 2), np.nan)
    if not np.isfinite(gain).all():
        raise unreachable(observer, period)
    return np.array([[float(f"{one:.{DIGITS}g}") for one in row] for row in gain])


def unreachable(observer: Block, period: float) -> ParameterError:
    """What to say where no gain is found."""
    first, *others = observer._fields[:4]
    beside = ", ".join(f"{name} = {getattr(observer, name):g}" for name in others)
    return ParameterError(
        f"{type(observer).__name__}.{first}",
        getattr(observer, first),
        f"with {beside} and a sample period of {period:g} s no gain is found: "
        "disturbance over noise is out of the reach of floating-point numbers",
    )


def sampled(rates: Matrix, period: float) -> tuple[Matrix, Matrix]:
    """The transition over a period, and the covariance that unit walks of the last two states add in it.

    Both come from one matrix exponential: Van Loan, IEEE Trans. Automatic Control 23(3), 1978.

    Raises:
        ValueError: the rates are not finite.
    """
    from scipy.linalg import expm

    size = len(rates)
    intensity = np.zeros((size, size))
    intensity[-2, -2] = intensity[-1, -1] = 1.0 / period
    both = expm(np.block([[-rates, intensity], [np.zeros((size, size)), rates.T]]) * np.float64(period))
    transition = both[size:, size:].T
    added = transition @ both[:size, size:]
    if not np.isfinite(added).all():
        raise ValueError("rates beyond floating-point numbers")
    return transition, 0.5 * (added + added.T)
