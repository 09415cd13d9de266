"""Robust stabilisation of a plant whose normalised coprime factors are uncertain."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["RobustController", "StateSpace", "robust_controller"]

Matrix = NDArray[np.float64]

SWEEPS = 100  # of balancing, at most


class StateSpace(NamedTuple):
    """dx/dt = A x + B u, y = C x.

    Attributes:
        a: shape (n, n).
        b: shape (n, inputs).
        c: shape (outputs, n).
    """

    a: Matrix
    b: Matrix
    c: Matrix


class RobustController(NamedTuple):
    """A controller for negative feedback, u = -K y.

    Attributes:
        k: K, with as many states as the plant.
        gamma: what the closed loop amplifies at most; 1/gamma is the stability margin.
        least_gamma: the least that any controller reaches.
    """

    k: StateSpace
    gamma: float
    least_gamma: float


def robust_controller(plant: StateSpace, factor: float = 1.1) -> RobustController:
    """The controller that stabilises all plants within 1/gamma of a plant, gamma = factor gamma_min.

    With the plant G = M^-1 N, its coprime factors normalised, M M* + N N* = 1, these are all
    (M + d_M)^-1 (N + d_N) with ||[d_M d_N]|| below 1/gamma. Two Riccati equations and no search give it::

        A' X + X A - X B B' X + C' C = 0,   A Z + Z A' - Z C' C Z + B B' = 0
        gamma_min = sqrt(1 + rho(X Z)),     W = ((gamma^2 - 1) 1 - Z X)^-1
        K = [A - B B' X - gamma^2 W Z C' C,  gamma^2 W Z C',  B' X]

    The states are scaled first so that SI numbers of any size go together, and time with them; inputs and
    outputs are not, for their weights are the design.

    Source: McFarlane, Glover, IEEE Trans. Automatic Control 37(6), 1992; Skogestad, Postlethwaite,
    Multivariable Feedback Control, 2005, sec. 9.4.1.
    Fails for a plant with feedthrough, which has other equations, and at factor 1, where K is of lower order.

    Args:
        plant: G, that can be stabilised, and all of which is seen.
        factor: gamma over the least there is, above 1.

    Raises:
        ValueError: there is no controller, or numbers out of the reach of floating point.
    """
    from scipy.linalg import solve_continuous_are

    with np.errstate(all="ignore"):
        (a, b, c), sizes, rate = balanced(plant)
        try:
            x = solve_continuous_are(a, b, c.T @ c, np.eye(b.shape[1]))
            z = solve_continuous_are(a.T, c.T, b @ b.T, np.eye(c.shape[0]))
            least = math.sqrt(1.0 + float(np.abs(np.linalg.eigvals(x @ z)).max()))
            gamma = factor * least
            weight = np.linalg.inv((gamma**2 - 1.0) * np.eye(len(a)) - z @ x)
        except np.linalg.LinAlgError as error:
            raise ValueError(f"no Riccati equation has a solution: {error}") from None
        gain = gamma**2 * weight @ z @ c.T
        k = StateSpace(a - b @ b.T @ x - gain @ c, gain, b.T @ x)
        k = StateSpace(rate * k.a, math.sqrt(rate) * k.b, math.sqrt(rate) * k.c)
        k = StateSpace(k.a * sizes[:, np.newaxis] / sizes, k.b * sizes[:, np.newaxis], k.c / sizes)
    if not all(np.isfinite(part).all() for part in k):
        raise ValueError("a controller beyond floating-point numbers")
    return RobustController(k, gamma, least)


def balanced(plant: StateSpace) -> tuple[StateSpace, Matrix, float]:
    """A plant in states of a size of their own and a time of its own: x/sizes and rate t.

    The rows and columns of [A B; C 0] that belong to a state get one size: Osborne, J. ACM 7(4), 1960.

    Raises:
        ValueError: its numbers are not finite.
    """
    if not all(np.isfinite(part).all() for part in plant):
        raise ValueError("a plant with numbers that are not finite")
    size = len(plant.a)
    whole = np.block([[plant.a, plant.b], [plant.c, np.zeros((len(plant.c), plant.b.shape[1]))]])
    sizes = np.ones(size)
    off = 1.0 - np.eye(*whole.shape)
    for _ in range(SWEEPS):
        before = sizes.copy()
        for i in range(size):
            row, column = np.abs(whole[i] * off[i]).max(), np.abs(whole[:, i] * off[:, i]).max()
            if row > 0.0 and column > 0.0:
                scale = 2.0 ** round(0.5 * math.log2(row / column))
                whole[i] /= scale
                whole[:, i] *= scale
                sizes[i] *= scale
        if (sizes == before).all():
            break
    a, b, c = whole[:size, :size], whole[:size, size:], whole[size:, :size]
    rate = float(np.abs(a).max()) or 1.0
    return StateSpace(a / rate, b / math.sqrt(rate), c / math.sqrt(rate)), sizes, rate
