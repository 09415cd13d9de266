"""An adaptive Runge-Kutta pair of order 5(4)."""

import math
from typing import Annotated, Any, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Integrator, role
from hydroservo.core.sources import CHOSEN
from hydroservo.core.states import axpy, misses, scaled
from hydroservo.machine.integrators.jumps import AFTER, BEFORE

TRUSTED = 0.5  # largest h |lambda| of the shortest step
SAFETY, LEAST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 5.0  # of one step's length over the last


class Progress(NamedTuple):
    """How far a sample period is integrated."""

    size: float  # of the next step [s]
    gone: float  # since the sample [s]
    since: float  # the last jump, or the sample [s]
    jumps: float  # met so far


@role(Integrator)
class Tsit5(NamedTuple):
    """Tsitouras' pair of order 5(4): steps as long as a tolerance allows, ending on samples and on jumps.

    A step is accepted if the root of the sum of its relative errors' squares is at most ``tolerance``; the
    error of each state is relative to the largest of its size before and after the step and what its rate
    would add in a sample period. The next step is 0.9 (tolerance/error)^(1/5) times as long, within 0.2 and
    5. The first one is a substep, and no memory goes from one sample period to the next.

    A step no longer than dt/``most_steps`` is accepted whatever its error, and after that many jumps in one
    sample period the others are stepped over, so the work is bounded. A state that is no longer finite ends
    the run.

    Source: Tsitouras, Computers & Mathematics with Applications 62(2), 2011, doi:10.1016/j.camwa.2011.06.002;
    step control: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, Sec. II.4.
    Fails to be quick where stability and not accuracy limits the step: on a stiff machine.
    """

    tolerance: Annotated[
        float, Field("", "largest relative error of a step", CHOSEN, at_least=1e-13, at_most=0.1)
    ] = 1e-8
    most_steps: Annotated[
        int, Field("", "steps of least length in a sample period", CHOSEN, at_least=1, at_most=1e5)
    ] = 1000

    def advance(self, system: Block, t: float, x: Block, u: Any, dt: float, substeps: int) -> Block:
        p = self.begin(t, dt, substeps)
        while p.gone < dt:
            x, p = self.attempt(system, t, x, u, dt, p)
        return x

    def begin(self, t: float, dt: float, substeps: int) -> Progress:
        return Progress(dt / substeps, 0.0, t, 0.0)

    def attempt(
        self, system: Block, t: float, x: Block, u: Any, dt: float, p: Progress
    ) -> tuple[Block, Progress]:
        shortest = dt / self.most_steps
        now = ops.maximum(t + p.gone, p.since)
        jump = ops.where(p.jumps < float(self.most_steps), system.next_jump(now, u), math.inf)
        stop = ops.minimum(jump - t, dt)
        left = stop - p.gone
        size = ops.where(2.0 * p.size < left, p.size, ops.where(p.size < left, 0.5 * left, left))
        y, error, rate = self.step(system, now, x, u, size, BEFORE * jump)
        miss = misses(error, x, y, rate, dt) / (self.tolerance * self.tolerance)
        factor = SAFETY * ops.power(miss, -0.1)
        longer = size * ops.where(
            ops.isfinite(miss), ops.clip(factor, LEAST_FACTOR, LARGEST_FACTOR), LEAST_FACTOR
        )
        if miss > 1.0 or ops.isnan(miss):
            if size > shortest:
                p = Progress(ops.maximum(longer, shortest), p.gone, p.since, p.jumps)
                return x, p
            if not ops.isfinite(miss):
                x, p = axpy(y, miss - miss, y), Progress(p.size, dt, p.since, p.jumps)  # not a number
                return x, p
        following = ops.maximum(ops.where(size < p.size, ops.maximum(p.size, longer), longer), shortest)
        x = y
        if size < left:
            p = Progress(following, p.gone + size, p.since, p.jumps)
        elif stop < dt:
            p = Progress(following, stop, AFTER * jump, p.jumps + 1.0)
        else:
            p = Progress(following, dt, p.since, p.jumps)
        return x, p

    def step(
        self, system: Block, t: float, x: Block, u: Any, h: float, last: float
    ) -> tuple[Block, Block, Block]:
        """The state one step later, its error, and the rates at the start.

        No rate is taken after the instant ``last``, so that a step that ends on a jump sees nothing of it.
        """
        end = ops.minimum(t + h, last)
        k1 = system.deriv(t, x, u)
        x2 = axpy(x, 0.161 * h, k1)
        k2 = system.deriv(ops.minimum(t + 0.161 * h, last), x2, u)
        x3 = axpy(axpy(x, -0.008480655492356989 * h, k1), 0.335480655492357 * h, k2)
        k3 = system.deriv(ops.minimum(t + 0.327 * h, last), x3, u)
        x4 = axpy(axpy(x, 2.8971530571054935 * h, k1), -6.359448489975075 * h, k2)
        x4 = axpy(x4, 4.3622954328695815 * h, k3)
        k4 = system.deriv(ops.minimum(t + 0.9 * h, last), x4, u)
        x5 = axpy(axpy(x, 5.325864828439257 * h, k1), -11.748883564062828 * h, k2)
        x5 = axpy(axpy(x5, 7.4955393428898365 * h, k3), -0.09249506636175525 * h, k4)
        k5 = system.deriv(ops.minimum(t + 0.9800255409045097 * h, last), x5, u)
        x6 = axpy(axpy(x, 5.86145544294642 * h, k1), -12.92096931784711 * h, k2)
        x6 = axpy(axpy(x6, 8.159367898576159 * h, k3), -0.071584973281401 * h, k4)
        x6 = axpy(x6, -0.028269050394068383 * h, k5)
        k6 = system.deriv(end, x6, u)
        y = axpy(axpy(x, 0.09646076681806523 * h, k1), 0.01 * h, k2)
        y = axpy(axpy(y, 0.4798896504144996 * h, k3), 1.379008574103742 * h, k4)
        y = axpy(axpy(y, -3.290069515436081 * h, k5), 2.324710524099774 * h, k6)
        k7 = system.deriv(end, y, u)
        error = axpy(scaled(-0.00178001105222577714 * h, k1), -0.0008164344596567469 * h, k2)
        error = axpy(axpy(error, 0.007880878010261995 * h, k3), -0.1447110071732629 * h, k4)
        error = axpy(axpy(error, 0.5823571654525552 * h, k5), -0.45808210592918697 * h, k6)
        error = axpy(error, h / 66.0, k7)
        return y, error, k1

    def trusted_rate(self, dt: float, substeps: int) -> float:
        return TRUSTED * self.most_steps / dt

    def substeps_for(self, rate: float, dt: float, tolerance: float) -> int:
        return 1
