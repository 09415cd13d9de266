"""The classical Runge-Kutta method."""

import math
from typing import Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.roles import Integrator, role
from hydroservo.core.states import axpy
from hydroservo.machine.integrators.jumps import BEFORE

TRUSTED = 0.5  # largest h |lambda|
SUBSTEPS = 10**6  # at most


@role(Integrator)
class RK4(NamedTuple):
    """The classical fourth-order method, in equal substeps that end on the samples.

    A mode that moves as e^(lambda t) is followed with a relative error near (h |lambda|)^4/120 per radian, so
    h |lambda| is trusted up to 0.5, where that is 5e-4. From 2.6 on the method may be unstable.

    Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, table II.1.2.
    Fails to keep its order where the load jumps inside a substep; a jump at its end does no harm.
    """

    def advance(self, system: Block, t: float, x: Block, u: Any, dt: float, substeps: int) -> Block:
        h = dt / substeps
        for i in range(substeps):
            x = self.substep(system, t + i * h, x, u, h)
        return x

    def substep(self, system: Block, t: float, x: Block, u: Any, h: float) -> Block:
        jump = system.next_jump(t, u)
        inside = ops.copysign(math.inf, BEFORE * (t + h) - jump)  # inf for a jump before the end, else -inf
        end = ops.minimum(t + h, ops.maximum(BEFORE * jump, inside))
        k1 = system.deriv(t, x, u)
        k2 = system.deriv(t + 0.5 * h, axpy(x, 0.5 * h, k1), u)
        k3 = system.deriv(t + 0.5 * h, axpy(x, 0.5 * h, k2), u)
        k4 = system.deriv(end, axpy(x, h, k3), u)
        inner = axpy(axpy(axpy(x, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3)
        return axpy(inner, h / 6.0, k4)

    def trusted_rate(self, dt: float, substeps: int) -> float:
        return TRUSTED * substeps / dt

    def substeps_for(self, rate: float, dt: float, tolerance: float) -> int:
        needed = rate * dt / math.sqrt(math.sqrt(120.0 * tolerance))
        return math.ceil(ops.clip(needed, 1.0, SUBSTEPS))
