"""Fixed-step integration of a machine between two samples."""

from typing import NamedTuple

from hydroservo.block import Block
from hydroservo.engine.tree import axpy

__all__ = ["RK4"]


class RK4(NamedTuple):
    """The classical fourth-order Runge-Kutta method, in equal substeps that end on the samples.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, table II.1.2.
    Fails to keep its order across a jump of the load inside a step, and may be unstable from
    h |lambda| = 2.6 on.
    """

    substeps: int = 1

    def advance(self, system: Block, t: float, x: Block, u: float, dt: float) -> Block:
        h = dt / self.substeps
        for i in range(self.substeps):
            x = self.substep(system, t + i * h, x, u, h)
        return x

    def substep(self, system: Block, t: float, x: Block, u: float, h: float) -> Block:
        k1 = system.deriv(t, x, u)
        k2 = system.deriv(t + 0.5 * h, axpy(x, 0.5 * h, k1), u)
        k3 = system.deriv(t + 0.5 * h, axpy(x, 0.5 * h, k2), u)
        k4 = system.deriv(t + h, axpy(x, h, k3), u)
        ends = axpy(axpy(x, h / 6.0, k1), h / 6.0, k4)
        return axpy(axpy(ends, h / 3.0, k2), h / 3.0, k3)
