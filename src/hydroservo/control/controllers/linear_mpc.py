"""Linear model predictive control with a fixed number of steps."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.state_feedback import (
    COMPUTED,
    Effort,
    ForceGain,
    ForceWeight,
    OpeningGain,
    SpoolTimeConstant,
    StateFeedback,
    VelocityGain,
)
from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.control.synthesis.predictive import planned
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, above, valve_known
from hydroservo.core.block import Block, Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Controller, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.vectors import matrix, vector
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

MOVES = 10
RULING = ("effort", "force_weight", "time_constant")

States = vector("States", 3, Field("V", "command per unit of x", COMPUTED, derived=True))
Moves = vector("Moves", MOVES, Field("V", "command of move", COMPUTED, derived=True))
FreeResponse = matrix("FreeResponse", States, Moves)
Update = matrix("Update", Moves, Moves)
NO_STATES = States(0.0, 0.0, 0.0)
NO_MOVES = Moves(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Limits(NamedTuple):
    """How far the commands of the moves, and their differences, may be from those without corrections [V]."""

    low: Block
    high: Block
    least_rise: Block
    largest_rise: Block


class LinearMPCState(NamedTuple):
    """The last command, the modelled spool and the observer's state."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    observer: Block
    unlimited: Annotated[float, Field("V", "command of the law without limits")]


@role(Controller)
@controlling(Velocity)
class LinearMPC(NamedTuple):
    """OffsetFreeLQ that looks ahead where its command meets a limit: the size of it, or its rate.

    Over ten moves of ``hold`` samples each, u is that of OffsetFreeLQ with the same weights plus a correction
    c a move. For that law's gain the cost of corrections is in proportion to the sum of c^2, whatever the
    state; so, with w what they change in the commands, v the commands without them and u' the last one::

        least w^T H w,   -limit <= v + w <= limit,   |v1 + w1 - u'| <= h rate,
                         |v + w - (v + w of the move before)| <= h hold rate
        u = sat(v1 + z1)

    v follows from the linear model at rest, led by x - xr of OffsetFreeLQ with demand and disturbances as
    they are now, and with the orifice's gain as it is now. w is found by ``steps`` steps of an alternating
    direction method of multipliers, each sample from 0: with D the differences of the moves, M = rho (H +
    rho (1 + D^T D))^-1, z and s as w and D w within their limits, and y, t the sums of what they are off by::

        w := M (z - y + D^T (s - t)),   z := clip(w + y),   y := y + w - z,
                                        s := clip(D w + t),   t := t + D w - s

    Where no limit binds w is 0 and the command is that of OffsetFreeLQ, bit for bit.

    Source: Kouvaritakis, Rossiter, Schuurmans, IEEE Trans. Automatic Control 45(8), 2000 (corrections of a
    law that is stable without them; unverified); Boyd et al., Foundations and Trends in Machine Learning
    3(1), 2011, sec. 5.2 (the method). The target: see OffsetFreeLQ. That the steps start from 0 is chosen
    here.
    Fails as OffsetFreeLQ. Where limits bind, steps that are too few leave a command that is not the best, and
    moves that end before the limits let go leave what comes behind them out. With a ``hold`` above 1 the plan
    keeps the limits at the first sample of each move alone. It sees no demand ahead: a jump meets it as any
    other law. Limits of pressures are not held.
    """

    effort: Effort
    time_constant: SpoolTimeConstant
    observer: Observer
    hold: Annotated[int, Field("", "samples of each of the ten moves", at_least=1, at_most=1000)]
    rate: Annotated[float, Field("V/s", "largest rate of the command", "auto: none", above=0, auto=OPEN)] = (
        OPEN
    )
    steps: Annotated[int, Field("", "steps of the method a sample", "chosen", at_least=1, at_most=10000)] = 30
    force_weight: ForceWeight = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gain_1: VelocityGain = 0.0
    gain_2: ForceGain = 0.0
    gain_3: OpeningGain = 0.0
    free_response: Block = FreeResponse(*[NO_STATES] * MOVES)
    update: Block = Update(*[NO_MOVES] * MOVES)

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        known = valve_known(self.time_constant, facts)
        if facts.command.value < facts.limit and facts.command_rate.value < self.rate:
            return [known]  # no limit binds, and the moves change nothing
        meaning = "ten moves of hold samples outlast the valve's lag and a swing of the oil"
        least = facts.valve_lag + 6.3 / facts.natural_frequency
        return [known, above("horizon", meaning, MOVES * self.hold * facts.period, least, "s")]

    def init(self) -> LinearMPCState:
        return LinearMPCState(0.0, 0.0, self.observer.init(), 0.0)

    def step(self, s: LinearMPCState, y: Measurement, r: Demand, dt: float) -> LinearMPCState:
        spool = SpoolLag(self.time_constant).under_held_command(s.opening, y.command, dt)
        o, x3 = self.observer.step(s.observer, self.model, y.with_command(spool.mean), dt), spool.opening
        law = StateFeedback(self.gain_1, self.gain_2, self.gain_3)
        unlimited = law.command(self.model, o.velocity, o.hydraulic_force, x3, o.d1, o.d2, r, 0.0)

        target = law.target(self.model, o.hydraulic_force, x3, o.d1, o.d2, r)
        x = States(
            (o.velocity - r.value) * target.gain,
            (o.hydraulic_force - target.hydraulic_force) * target.gain,
            x3 - target.opening,
        )
        ahead = self.free_response.times(x).with_first(unlimited - target.opening)
        correction = self.correction(self.limits(ahead, target.opening, y.command, dt))
        u = self.saturation.apply(unlimited + correction)
        return LinearMPCState(u, x3, o, unlimited)

    def limits(self, ahead: Block, target: float, last: float, dt: float) -> Limits:
        """Those that are left for corrections of the commands ahead of a target [V]."""
        limit, rise = self.saturation.limit, self.rate * dt
        first = last - target
        low = ops.maximum(-limit - target, first - rise)
        high = ops.minimum(limit - target, first + rise)
        rises = ahead.differences()
        farthest = ahead.filled(rise * self.hold).minus(rises).with_first(OPEN)
        nearest = ahead.filled(-rise * self.hold).minus(rises).with_first(-OPEN)
        return Limits(
            ahead.filled(-limit - target).with_first(low).minus(ahead),
            ahead.filled(limit - target).with_first(high).minus(ahead),
            nearest,
            farthest,
        )

    def correction(self, limits: Limits) -> float:
        """z1 [V]."""
        nothing = limits.low.filled(0.0)
        z, s = (
            nothing.clipped(limits.low, limits.high),
            nothing.clipped(limits.least_rise, limits.largest_rise),
        )
        y, t = nothing, nothing
        for _ in range(self.steps):
            w = self.update.times(z.minus(y).plus(s.minus(t).differences_transposed()))
            rise = w.differences()
            z, s = (
                w.plus(y).clipped(limits.low, limits.high),
                rise.plus(t).clipped(limits.least_rise, limits.largest_rise),
            )
            y, t = y.plus(w).minus(z), t.plus(rise).minus(s)
        first: float = z.e1
        return first

    def designed(self, model: DesignModel, period: float) -> "LinearMPC":
        """The law with its gains and its plan for a model and a sample period [s].

        Raises:
            ParameterError: there are none, they are beyond the range of floating-point numbers, or the
                horizon is too short for the limits.
        """
        ahead, limit = MOVES * self.hold * period, self.saturation.limit
        if self.rate * ahead < limit:
            problem = (
                f"must be at least {limit / ahead:g} [V/s], so that the command gets from 0 to its limit of "
                f"{limit:g} V within the horizon of {ahead:g} s; or take a hold above {self.hold}"
            )
            raise ParameterError("LinearMPC.rate", self.rate, problem)
        (k1, k2, k3), free, update = planned(self, RULING, model, period, MOVES)
        return self._replace(
            gain_1=float(k1),
            gain_2=float(k2),
            gain_3=float(k3),
            free_response=FreeResponse(*(States(*row) for row in free.tolist())),
            update=Update(*(Moves(*row) for row in update.tolist())),
        )
