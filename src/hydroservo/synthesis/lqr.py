"""State feedback that is best by a quadratic measure."""

import warnings
from collections.abc import Sequence

import numpy as np

from hydroservo.block import Block
from hydroservo.plants.design_model import DesignModel
from hydroservo.synthesis.gains import no_gain, rounded
from hydroservo.synthesis.linear_model import at_rest
from hydroservo.synthesis.matrix import Matrix
from hydroservo.synthesis.memory import NOTHING, Memory, remembering
from hydroservo.synthesis.sampled import under_held_input

__all__ = ["feedback", "lqr"]


def lqr(transition: Matrix, driven: Matrix, weights: Matrix, effort: float) -> Matrix:
    """The gain K of u = -K x that makes the sum of |W x|^2 + (rho u)^2 over all samples least.

    With F and G the transition and what a held input adds, X solves the discrete algebraic Riccati equation::

        X = F^T X F - F^T X G (G^T X G + rho^2)^-1 G^T X F + W^2,   K = (G^T X G + rho^2)^-1 G^T X F

    Args:
        transition: F, shape (n, n).
        driven: G, shape (n,).
        weights: the diagonal of W, shape (n,).
        effort: rho.

    Returns:
        Shape (n,).

    Raises:
        numpy.linalg.LinAlgError: no gain makes it stable, or none is found.
        ValueError: what is given is not finite.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 9.2; Anderson, Moore,
    Optimal Control: Linear Quadratic Methods, 1990.
    Fails where the states, or the weights, are of very different sizes: scale them before.
    """
    from scipy.linalg import LinAlgWarning, solve_discrete_are

    inputs, price = driven[:, np.newaxis], np.array([[effort * effort]])
    with warnings.catch_warnings():
        warnings.simplefilter("error", LinAlgWarning)
        try:
            cost = solve_discrete_are(transition, inputs, np.diag(weights * weights), price)
        except LinAlgWarning as warning:
            raise np.linalg.LinAlgError(str(warning)) from None
    moved = cost @ driven
    gain: Matrix = (moved @ transition) / (moved @ driven + price[0, 0])
    closed = transition - np.outer(driven, gain)
    if not np.abs(np.linalg.eigvals(closed)).max() < 1.0:
        raise np.linalg.LinAlgError("not stable")
    return gain


def feedback(
    law: Block, names: Sequence[str], model: DesignModel, period: float, memory: Memory = NOTHING
) -> list[float]:
    """The gains of a law from x1, x2 and x3 of the model at rest, and from what it remembers, to its command.

    Args:
        law: that which is designed: with the velocity error that a volt counts for as its ``effort``, that a
            newton counts for as its ``force_weight``, and the valve's ``time_constant``.
        names: of its numbers that rule the design, for what is said where there is none.
        model: the design model.
        period: sample period [s].
        memory: of the velocity's error.

    Returns:
        [V per the unit of each] in nine digits, x1 to x3 first; that of x3 is 0 where the valve has no lag.

    Raises:
        ParameterError: there are none, or they are out of the reach of floating-point numbers.
    """
    try:
        with np.errstate(all="ignore"):
            gain = gain_at_rest(law, model, period, memory)
    except (ArithmeticError, np.linalg.LinAlgError, ValueError):
        gain = np.full(1, np.nan)
    if not np.isfinite(gain).all():
        raise no_gain(law, names, period, "they, or the model, are")
    found: list[float] = rounded(gain[np.newaxis])[0].tolist()
    return found


def gain_at_rest(law: Block, model: DesignModel, period: float, memory: Memory) -> Matrix:
    """The gains as :func:`feedback` returns them, in all digits."""
    plant = at_rest(model, law.time_constant)
    scaled, states = plant.scaled(), len(plant.sizes)
    sampled = under_held_input(scaled.rates, scaled.driven, period)
    weights = np.array([1.0, law.force_weight, 0.0])[:states] * plant.sizes
    every = np.concatenate([weights, np.ones(len(memory.rates))])
    found = lqr(*remembering(*sampled, memory), every, law.effort * plant.command) * plant.command
    of_states = np.zeros(3)
    of_states[:states] = found[:states] / plant.sizes
    return np.concatenate([of_states, found[states:] * memory.rates])
