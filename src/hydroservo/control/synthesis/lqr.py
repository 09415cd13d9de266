"""State feedback that is best by a quadratic measure."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydroservo.control.synthesis.gains import computed, no_gain
from hydroservo.control.synthesis.linear_model import model_at_rest
from hydroservo.control.synthesis.matrix import Matrix
from hydroservo.control.synthesis.memory import NOTHING, ErrorMemory, remembering
from hydroservo.control.synthesis.riccati import solution
from hydroservo.control.synthesis.sampled import under_held_input
from hydroservo.core.block import Block
from hydroservo.machine.plants.design_model import DesignModel


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
    inputs, price = driven[:, np.newaxis], np.array([[effort * effort]])
    moved = solution(transition, inputs, np.diag(weights * weights), price) @ driven
    gain: Matrix = (moved @ transition) / (moved @ driven + price[0, 0])
    return gain


def feedback(
    law: Block, names: Sequence[str], model: DesignModel, period: float, memory: ErrorMemory = NOTHING
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
        ParameterError: there are none, or they are beyond the range of floating-point numbers.
    """

    def design() -> list[Matrix]:
        found = designed_at_rest(law, model, period, memory)
        return [found.of_states(found.gain[np.newaxis])]

    (gain,) = computed(design, no_gain(law, names, period, "they, or the model, are"))
    found: list[float] = gain[0].tolist()
    return found


class Design(NamedTuple):
    """A linear quadratic law for the model at rest, scaled."""

    # F over a sample of the model's n states and m numbers of a memory, shape (n + m, n + m)
    transition: Matrix
    driven: Matrix  # G of the command, shape (n + m,)
    gain: Matrix  # K, shape (n + m,)
    sizes: Matrix  # what the states are scaled by, shape (n,)
    rates: Matrix  # what the memory is scaled by, shape (m,)
    command: float  # what the command is scaled by [V]

    def of_states(self, scaled: Matrix) -> Matrix:
        """Rows that give commands from scaled states, as rows for [x1, x2, x3] and the memory, in volts."""
        states = len(self.sizes)
        found = np.zeros((len(scaled), 3 + len(self.rates)))
        found[:, :states] = self.command * scaled[:, :states] / self.sizes
        found[:, 3:] = self.command * scaled[:, states:] * self.rates
        return found


def designed_at_rest(law: Block, model: DesignModel, period: float, memory: ErrorMemory = NOTHING) -> Design:
    """The law's design, as :func:`feedback` has it.

    Raises:
        numpy.linalg.LinAlgError: there is none.
        ValueError: what is given is not finite.
    """
    plant = model_at_rest(model, law.time_constant)
    scaled, states = plant.scaled(), len(plant.sizes)
    sampled = under_held_input(scaled.rates, scaled.driven, period)
    weights = np.array([1.0, law.force_weight, 0.0])[:states] * plant.sizes
    every = np.concatenate([weights, np.ones(len(memory.rates))])
    transition, driven = remembering(*sampled, memory)
    gain = lqr(transition, driven, every, law.effort * plant.command)
    return Design(transition, driven, gain, plant.sizes, memory.rates, plant.command)
