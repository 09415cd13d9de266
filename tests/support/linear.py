"""A sampled law around the load-pressure machine, linearised at rest."""

from typing import Any

import numpy as np
from scipy.linalg import expm

from hydroservo.core.block import Block, leaves, replace, values
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants import DesignModel

Matrix = np.ndarray[Any, np.dtype[np.float64]]


class Sampled:
    """x_(k+1) = A x_k + B r_k: velocity, hydraulic force and position of the machine, then the law's state.

    Args:
        law: a law that is linear near rest, its own signal filled in.
        model: the machine, with a valve without lag.
        period: the sample period [s].
    """

    def __init__(self, law: Any, model: DesignModel, period: float) -> None:
        self.law, self.period = law, period
        self.rest = law.step(law.init(), seen(np.zeros(3), 0.0), Demand(0.0, 0.0, 0.0), period)
        self.names = [name for name, _ in leaves(self.rest)]
        oil = [model.f2(1.0, 0.0), model.f2(0.0, 1.0), 0.0]
        body = np.zeros((4, 4))  # of the machine, and below it the held command
        body[:3, :3] = [[model.f1_slope(), model.g1(), 0.0], oil, [1.0, 0.0, 0.0]]
        body[1, 3] = model.g2(0.0, 0.0)
        self.body = expm(body * period)[:3]
        size = 3 + len(self.names)
        basis = 1e-6 * np.eye(size)
        self.a: Matrix = np.array([self.after(x, 0.0) for x in basis]).T / 1e-6
        self.b: Matrix = self.after(np.zeros(size), 1e-6) / 1e-6

    def after(self, x: Matrix, demand: float) -> Matrix:
        """The state a sample later."""
        before: Block = replace(self.rest, dict(zip(self.names, map(float, x[3:]), strict=True)))
        law = self.law.step(before, seen(x, before.u), Demand(demand, 0.0, 0.0), self.period)
        return np.concatenate((self.body @ [*x[:3], law.u], values(law)))

    def poles(self) -> Matrix:
        """In continuous time [1/s]; without those at the origin of the discrete plane."""
        found = np.linalg.eigvals(self.a)
        return np.log(found[abs(found) > 1e-9].astype(complex)) / self.period

    def damping(self) -> float:
        """The damping ratio of the pair that swings fastest."""
        pole = max(self.poles(), key=lambda s: s.imag)
        return float(-pole.real / abs(pole))

    def response(self, frequency: float) -> complex:
        """Position over the demand at a frequency [Hz]."""
        z = np.exp(2j * np.pi * frequency * self.period)
        return complex(np.linalg.solve(z * np.eye(len(self.a)) - self.a, self.b)[2])


def seen(x: Matrix, command: float) -> Measurement:
    return Measurement(float(x[0]), float(x[1]), float(x[2]), command, 0.0, 0.0, 0.0)
