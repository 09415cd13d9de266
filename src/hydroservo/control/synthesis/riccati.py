"""Riccati equations in discrete time, to the last digits."""

import warnings

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix

NOTHING = 1e-30  # of what is left of a state
DOUBLINGS = 64


def solution(transition: Matrix, driven: Matrix, weights: Matrix, price: Matrix) -> Matrix:
    """The stabilising X of the discrete algebraic Riccati equation.

    With F, G, Q and R these are::

        X = F^T X F - F^T X G (G^T X G + R)^-1 G^T X F + Q

    A solution by LAPACK has lost up to half of its digits where the closed loop is slow, and others on
    another processor. One step of Newton's method doubles those that are right: the cost of the gain K that
    was found, X = (F - G K)^T X (F - G K) + Q + K^T R K, summed up in extended precision.

    Args:
        transition: F, shape (n, n).
        driven: G, shape (n, m).
        weights: Q, shape (n, n), symmetric.
        price: R, shape (m, m), symmetric.

    Returns:
        Shape (n, n).

    Raises:
        numpy.linalg.LinAlgError: no gain makes it stable, or none is found.
        ValueError: what is given is not finite.

    Source: Hewer, IEEE Trans. Automatic Control 16(4), 1971 (Newton's method); Smith, SIAM J. Applied
    Mathematics 16(1), 1968 (the sum, doubled each time).
    Fails where the states, or their weights, are of very different sizes: scale them before.
    """
    from scipy.linalg import LinAlgWarning, solve_discrete_are

    with warnings.catch_warnings():
        warnings.simplefilter("error", LinAlgWarning)
        try:
            found = solve_discrete_are(transition, driven, weights, price)
        except LinAlgWarning as warning:
            raise np.linalg.LinAlgError(str(warning)) from None
    gain = np.linalg.solve(driven.T @ found @ driven + price, driven.T @ found @ transition)
    return power_sum(transition - driven @ gain, weights + gain.T @ price @ gain)


def power_sum(transition: Matrix, weights: Matrix) -> Matrix:
    """The sum of (F^k)^T Q F^k over all k from 0.

    Raises:
        numpy.linalg.LinAlgError: it has no bound.
    """
    moved, total = transition.astype(np.longdouble), weights.astype(np.longdouble)
    for _ in range(DOUBLINGS):
        total, moved = total + moved.T @ total @ moved, moved @ moved
        if np.abs(moved).max() < NOTHING:
            return total.astype(np.float64)
    raise np.linalg.LinAlgError("not stable")
