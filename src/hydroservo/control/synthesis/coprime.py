"""Robust stabilisation of a plant whose normalised coprime factors are uncertain."""

import math
from typing import NamedTuple

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix


class StateMatrices(NamedTuple):
    """dx/dt = A x + B u, y = C x + D u."""

    a: Matrix  # shape (n, n)
    b: Matrix  # shape (n, inputs)
    c: Matrix  # shape (outputs, n)
    d: Matrix  # shape (outputs, inputs)


class RobustController(NamedTuple):
    """A controller for negative feedback, u = -K y."""

    k: StateMatrices  # K, with as many states as the plant
    gamma: float  # what the closed loop amplifies at most; 1/gamma is the stability margin
    least_gamma: float  # the least that any controller reaches


def robust_controller(plant: StateMatrices, factor: float = 1.1) -> RobustController:
    """The controller that stabilises all plants within 1/gamma of a plant, gamma = factor gamma_min.

    With the plant G = M^-1 N, its coprime factors normalised, M M* + N N* = 1, these are all
    (M + d_M)^-1 (N + d_N) with ||[d_M d_N]|| below 1/gamma. With S = 1 + D' D, R = 1 + D D' and
    A_0 = A - B S^-1 D' C two Riccati equations and no search give it::

        A_0' X + X A_0 - X B S^-1 B' X + C' R^-1 C = 0
        A_0 Z + Z A_0' - Z C' R^-1 C Z + B S^-1 B' = 0
        gamma_min = sqrt(1 + rho(X Z)),   F = -S^-1 (D' C + B' X)
        H = gamma^2 ((gamma^2 - 1) 1 - Z X)^-1 Z C'
        K = [A + B F - H (C + D F), H, B' X, D']

    The states are scaled first so that SI numbers of any size go together, and time with them; inputs and
    outputs are not, for their weights are the design.

    Source: McFarlane, Glover, IEEE Trans. Automatic Control 37(6), 1992; Skogestad, Postlethwaite,
    Multivariable Feedback Control, 2005, sec. 9.4.1.
    Fails at factor 1, where K is of lower order.

    Args:
        plant: G, all of which can be stabilised and is seen.
        factor: gamma over the least there is, above 1.

    Raises:
        ValueError: there is no controller, or it is beyond the range of floating-point numbers.
    """
    from scipy.linalg import solve_continuous_are

    with np.errstate(all="ignore"):
        (a, b, c, d), sizes, rate = balanced(plant)
        s, r = np.eye(d.shape[1]) + d.T @ d, np.eye(d.shape[0]) + d @ d.T
        try:
            free = a - b @ np.linalg.solve(s, d.T @ c)
            x = solve_continuous_are(free, b, c.T @ np.linalg.solve(r, c), s)
            z = solve_continuous_are(free.T, c.T, b @ np.linalg.solve(s, b.T), r)
            least = math.sqrt(1.0 + float(np.abs(np.linalg.eigvals(x @ z)).max()))
            gamma = factor * least
            heard = gamma**2 * np.linalg.solve((gamma**2 - 1.0) * np.eye(len(a)) - z @ x, z @ c.T)
            felt = -np.linalg.solve(s, d.T @ c + b.T @ x)
        except (np.linalg.LinAlgError, ValueError):
            raise ValueError("a Riccati equation has no solution in floating-point numbers") from None
        k = rescaled(StateMatrices(a + b @ felt - heard @ (c + d @ felt), heard, b.T @ x, d.T), sizes, rate)
    if not all(np.isfinite(part).all() for part in k):
        raise ValueError("it is beyond the range of floating-point numbers")
    return RobustController(k, gamma, least)


def balanced(plant: StateMatrices) -> tuple[StateMatrices, Matrix, float]:
    """A plant in states of a size of their own and a time of its own: x/sizes and rate t.

    The rows and columns of [A B; C 0] that belong to a state get one size, by LAPACK's balancing.

    Raises:
        ValueError: its numbers are not finite.
    """
    if not all(np.isfinite(part).all() for part in plant):
        raise ValueError("it is beyond the range of floating-point numbers")
    from scipy.linalg import matrix_balance

    (states, inputs), outputs = plant.b.shape, len(plant.c)
    whole = np.zeros((states + inputs + outputs,) * 2)  # inputs without rows, outputs without columns stay
    whole[:states, : states + inputs] = np.hstack([plant.a, plant.b])
    whole[states + inputs :, :states] = plant.c
    _, (scale, _) = matrix_balance(whole, permute=False, separate=True)
    sizes = scale[:states]
    a, b, c = plant.a * sizes / sizes[:, np.newaxis], plant.b / sizes[:, np.newaxis], plant.c * sizes
    rate = float(np.abs(a).max()) or 1.0
    return StateMatrices(a / rate, b / math.sqrt(rate), c / math.sqrt(rate), plant.d), sizes, rate


def rescaled(law: StateMatrices, sizes: Matrix, rate: float) -> StateMatrices:
    """What is balanced, as it was before."""
    root, rows = math.sqrt(rate), sizes[:, np.newaxis]
    return StateMatrices(rate * law.a * rows / sizes, root * law.b * rows, root * law.c / sizes, law.d)
