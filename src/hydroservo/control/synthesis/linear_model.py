"""The design model linearised at rest."""

import math
from typing import NamedTuple

import numpy as np

from hydroservo.control.synthesis.matrix import Matrix
from hydroservo.machine.plants.design_model import DesignModel


class LinearModel(NamedTuple):
    """dx/dt = A x + B u, with one input."""

    rates: Matrix  # A, shape (n, n)
    driven: Matrix  # B, shape (n,), per volt
    names: tuple[str, ...]  # of the states, as the law's equations write them
    sizes: Matrix  # of the states where the velocity is 1 m/s, by which SI numbers are scaled to go together
    command: float  # the size of u [V] there

    def scaled(self) -> "LinearModel":
        """The same in states and command of size 1."""
        return LinearModel(
            self.rates * self.sizes / self.sizes[:, np.newaxis],
            self.driven * self.command / self.sizes,
            self.names,
            np.ones_like(self.sizes),
            1.0,
        )


def model_at_rest(model: DesignModel, time_constant: float) -> LinearModel:
    """The model about rest, behind a valve of first order; x = [x1, x2, x3], or [x1, x2] without the lag.

    With x3 the valve's opening as the command that would hold it::

        dx1/dt = f1' x1 + g1 x2,   dx2/dt = f2(x1, x2) + g2(0) x3,   tau dx3/dt = u - x3

    The sizes of x2 and x3 are those in an oscillation on the oil's spring, and in steady motion, at 1 m/s.

    Args:
        model: what is believed of the machine.
        time_constant: tau [s] of the valve; 0 for one without lag, whose x3 is u.
    """
    rates = np.zeros((3, 3))
    rates[:2, :2] = free_rates(model)
    rates[1, 2] = model.g2(0.0, 0.0)
    sizes = np.array([1.0, math.sqrt(-rates[1, 0] / rates[0, 1]), -rates[1, 0] / rates[1, 2]])
    command = float(sizes[2])
    if time_constant == 0.0:
        return LinearModel(rates[:2, :2], rates[:2, 2], ("x1", "x2"), sizes[:2], command)
    rates[2, 2] = -1.0 / time_constant
    return LinearModel(rates, np.array([0.0, 0.0, 1.0 / time_constant]), ("x1", "x2", "x3"), sizes, command)


def free_rates(model: DesignModel) -> Matrix:
    """d/dt of [x1, x2] at rest with the valve closed, shape (2, 2)."""
    return np.array([[model.f1(1.0), model.g1()], [model.f2(1.0, 0.0), model.f2(0.0, 1.0)]])


def with_disturbances(model: DesignModel) -> Matrix:
    """d/dt of [x1, x2, d_L1, d_L2] at rest with the valve closed, shape (4, 4)."""
    rates = np.zeros((4, 4))
    rates[:2, :2] = free_rates(model)
    rates[0, 2] = rates[1, 3] = 1.0
    return rates
