"""What a linear law with limits on its command has to know of the moves ahead."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydroservo.control.synthesis.gains import computed, no_gain
from hydroservo.control.synthesis.lqr import designed_at_rest
from hydroservo.control.synthesis.matrix import Matrix
from hydroservo.core.block import Block
from hydroservo.machine.plants.design_model import DesignModel


class Plan(NamedTuple):
    """How commands follow from states and from corrections, over a horizon of m moves."""

    free_response: Matrix  # the commands without corrections, per state; shape (m, n)
    update: Matrix  # the matrix by which the splitting finds commands, shape (m, m)


def plan(transition: Matrix, driven: Matrix, gain: Matrix, moves: int, hold: int) -> Plan:
    """Of a linear law u = -K x + c with corrections c that are constant over moves of ``hold`` samples each.

    With the gain K of a linear quadratic law any correction costs in proportion to its square, whatever the
    state, so that the sum of c^2 is what limits are to cost least of. With v = free x + T c the commands at
    the first sample of each move, w = T c, D the differences of the moves and rho the price of the
    splitting::

        least sum of c^2 = w^T H w,   H = T^-T T^-1,   update = rho (H + rho (1 + D^T D))^-1

    rho is the geometric mean of the extreme eigenvalues of H.

    Args:
        transition: F of the plant, shape (n, n).
        driven: G of the plant, shape (n,).
        gain: K, shape (n,).
        moves: m.
        hold: samples of each move.

    Raises:
        numpy.linalg.LinAlgError: the numbers are too far apart.

    Source: Kouvaritakis, Rossiter, Schuurmans, IEEE Trans. Automatic Control 45(8), 2000 (corrections of a
    law that is stable without them; unverified); Boyd et al., Foundations and Trends in Machine Learning
    3(1), 2011, sec. 5.2 (the splitting).
    Fails where K leaves the loop slow against the horizon.
    """
    closed = transition - np.outer(driven, gain)
    free, answers = np.zeros((moves, len(gain))), np.zeros((moves, moves))
    states, answer = np.eye(len(gain)), np.zeros((len(gain), moves))
    for i in range(moves):
        free[i], answers[i] = -gain @ states, -gain @ answer
        answers[i, i] += 1.0
        for _ in range(hold):
            states, answer = closed @ states, closed @ answer
            answer[:, i] += driven
    back = np.linalg.inv(answers)
    cost = back.T @ back
    least, *_, largest = np.linalg.eigvalsh(cost)
    price = np.sqrt(least * largest)
    rises = np.eye(moves) - np.eye(moves, k=-1)
    update = price * np.linalg.inv(cost + price * (np.eye(moves) + rises.T @ rises))
    return Plan(free, update)


def planned(
    law: Block, names: Sequence[str], model: DesignModel, period: float, moves: int
) -> tuple[Matrix, Matrix, Matrix]:
    """The gains of a law's linear quadratic design, and its plan of that many moves of ``law.hold`` samples.

    Args:
        law: that which is designed, as :func:`~hydroservo.control.synthesis.lqr.feedback` takes it.
        names: of its numbers that rule the design, for what is said where there is none.
        model: the design model.
        period: sample period [s].
        moves: m.

    Returns:
        The gain [V per the unit of x1, x2, x3], shape (3,), and the plan's two matrices for states in the
        same units, shapes (m, 3) and (m, m); all in nine digits.

    Raises:
        ParameterError: there are none, or they are beyond the range of floating-point numbers.
    """

    def design() -> list[Matrix]:
        linear = designed_at_rest(law, model, period)
        found = plan(linear.transition, linear.driven, linear.gain, moves, law.hold)
        of_states = linear.of_states
        return [of_states(linear.gain[np.newaxis]), of_states(found.free_response), found.update]

    gain, free, update = computed(design, no_gain(law, names, period, "they, or the model, are"))
    return gain[0], free, update
