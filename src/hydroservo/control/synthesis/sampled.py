"""Linear models from one sample to the next, each by one matrix exponential."""

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix


def under_held_input(rates: Matrix, driven: Matrix, period: float) -> tuple[Matrix, Matrix]:
    """The transition over a period, and what an input held over it adds.

    With dx/dt = A x + B u the exponential of [[A, B], [0, 0]] h is [[exp(A h), int exp(A s) B ds], [0, 1]].

    Args:
        rates: A, shape (n, n).
        driven: B, shape (n,).
        period: h [s].

    Returns:
        Shapes (n, n) and (n,).

    Raises:
        ValueError: the rates are not finite.

    Source: Van Loan, IEEE Trans. Automatic Control 23(3), 1978, doi:10.1109/TAC.1978.1101743.
    Fails where rates times the period are far from 1: the exponential's accuracy is relative to its largest
    entry. Scale the states before.
    """
    from scipy.linalg import expm

    size = len(rates)
    both = np.zeros((size + 1, size + 1))
    both[:size, :size], both[:size, size] = rates, driven
    found = expm(both * np.float64(period))
    if not np.isfinite(found).all():
        raise ValueError("rates beyond floating-point numbers")
    return found[:size, :size], found[:size, size]


def under_white_noise(rates: Matrix, intensity: Matrix, period: float) -> tuple[Matrix, Matrix]:
    """The transition over a period, and the covariance that white noise adds in it.

    With dx/dt = A x + w and W the intensity of w, [[F11, F12], [0, F22]] the exponential of
    [[-A, W], [0, A^T]] h, they are F22^T and F22^T F12.

    Args:
        rates: A, shape (n, n).
        intensity: W, shape (n, n), symmetric.
        period: h [s].

    Returns:
        Two of shape (n, n), the second symmetric.

    Raises:
        ValueError: the rates are not finite.

    Source: Van Loan, IEEE Trans. Automatic Control 23(3), 1978, doi:10.1109/TAC.1978.1101743.
    Fails as :func:`under_held_input`.
    """
    from scipy.linalg import expm

    size = len(rates)
    both = expm(np.block([[-rates, intensity], [np.zeros((size, size)), rates.T]]) * np.float64(period))
    transition = both[size:, size:].T
    added = transition @ both[:size, size:]
    if not np.isfinite(added).all():
        raise ValueError("rates beyond floating-point numbers")
    return transition, 0.5 * (added + added.T)
