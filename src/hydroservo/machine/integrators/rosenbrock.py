"""A linearly implicit method of third order, for stiff machines."""

import math
from typing import Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.roles import Integrator, role
from hydroservo.core.states import axpy, factored, solved
from hydroservo.machine.integrators.jumps import BEFORE

GAMMA = 0.435866521508459


@role(Integrator)
class Rosenbrock(NamedTuple):
    """ROS34PW2: four stages with one Jacobian, in equal substeps that end on the samples.

    (1/(gamma h) - J) u_i = f(t + alpha_i h, x + sum_j a_ij u_j) + sum_j c_ij/h u_j,   x(t + h) = x_4 + u_4

    with x_4 the last stage's argument, j < i, and J from differences of f, one for each state. The order is
    three with any J, so differences do. It is L-stable: a motion too fast for the step dies out within it
    and leaves the others alone, however stiff an oil volume or a stop is. A step costs as much as one of RK4
    for each four states, and more.

    Source: Rang, Angermann, BIT Numerical Mathematics 45(4), 2005, doi:10.1007/s10543-005-0035-y, in the
    form of Hairer, Wanner, Solving Ordinary Differential Equations II, 1996, eq. IV.7.25.
    Fails to say from the machine's fastest motion whether its steps are short enough: only halving them does.
    Its matrix is solved without pivoting, which a motion that grows by e within a step could upset.
    """

    def advance(self, system: Block, t: float, x: Block, u: Any, dt: float, substeps: int) -> Block:
        h = dt / substeps
        for i in range(substeps):
            x = self.substep(system, t + i * h, x, u, h)
        return x

    def substep(self, system: Block, t: float, x: Block, u: Any, h: float) -> Block:
        jump = system.next_jump(t, u)
        inside = ops.copysign(math.inf, BEFORE * (t + h) - jump)  # inf for a jump before the end, else -inf
        last = ops.maximum(BEFORE * jump, inside)
        f = system.deriv(t, x, u)
        matrix = factored(system, t, x, u, f, GAMMA * h)
        u1 = solved(matrix, f)
        x2 = axpy(x, 2.0, u1)
        f = system.deriv(ops.minimum(t + 0.871733043016918 * h, last), x2, u)
        u2 = solved(matrix, axpy(f, -4.588560720558083 / h, u1))
        x3 = axpy(axpy(x, 1.4192173174557647, u1), -0.2592322116729697, u2)
        f = system.deriv(ops.minimum(t + 0.7315799577888524 * h, last), x3, u)
        f = axpy(axpy(f, -4.184760482319161 / h, u1), 0.28519201735549591 / h, u2)
        u3 = solved(matrix, f)
        x4 = axpy(axpy(x, 4.184760482319161, u1), -0.28519201735549591, u2)
        x4 = axpy(x4, 2.2942803602790417, u3)
        f = system.deriv(ops.minimum(t + h, last), x4, u)
        f = axpy(axpy(f, -6.3681792001283578 / h, u1), -6.7956209444668362 / h, u2)
        f = axpy(f, 2.8700986043310561 / h, u3)
        return axpy(x4, 1.0, solved(matrix, f))

    def trusted_rate(self, dt: float, substeps: int) -> float:
        return math.inf

    def substeps_for(self, rate: float, dt: float, tolerance: float) -> int:
        return 1
