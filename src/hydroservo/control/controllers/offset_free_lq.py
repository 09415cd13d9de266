"""State feedback that is best by a quadratic measure, without offset by an observer's disturbances."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.state_feedback import (
    Effort,
    ForceGain,
    ForceWeight,
    OpeningGain,
    SpoolTimeConstant,
    StateFeedback,
    VelocityGain,
)
from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.control.synthesis.lqr import feedback
from hydroservo.core.assumptions import Assumption, Facts, robust, valve_known, within_limit
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

RULING = ("effort", "force_weight", "time_constant")


class OffsetFreeLQState(NamedTuple):
    """The last command, the modelled spool and the observer's state."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    observer: Block


@role(Controller)
@controlling(Velocity)
class OffsetFreeLQ(NamedTuple):
    """Velocity, hydraulic force and the valve's opening led to where demand and disturbances put them.

    With x = [x1, x2, x3], x3 the modelled opening in volts, and d1, d2, x1 and x2 as the nested ``observer``
    hands them on::

        x1r = r,   x2r = (r' - f1(r) - d1)/g1,   x3r = ((r'' - f1' r')/g1 - f2(x1r, x2r) - d2)/g2(x2, x3)
        u   = sat( x3r - g2(0)/g2(x2, x3) (k1 (x1 - x1r) + k2 (x2 - x2r)) - k3 (x3 - x3r) )

    K = [k1, k2, k3] is computed before a run: that which makes the sum over all samples of
    (x1 - x1r)^2 + (w (x2 - x2r))^2 + (rho (u - x3r))^2 least, with rho the ``effort`` and w the
    ``force_weight``, for the model at rest with the valve's lag, sampled under a held command. The observer
    is told of the mean modelled opening over the last period in place of the command, so that the lag is no
    disturbance to it. One whose estimates settle leaves no steady error under a load that stays, whatever
    the machine's parameters, as long as the loop is stable.

    Source: Anderson, Moore, Optimal Control: Linear Quadratic Methods, 1990 (the gain); Pannocchia, Rawlings,
    AIChE Journal 49(2), 2003, and Maeder, Borrelli, Morari, Automatica 45(10), 2009 (the target; unverified).
    Fails where little effort buys speed with robustness, of which an estimated state promises none (Doyle,
    IEEE Trans. Automatic Control 23(4), 1978): as the effort goes to 0 the law inverts its model, and is lost
    with a valve twice as fast, or with some observers on parameters 20 % off. Where a lagging valve moves
    much within a period, an observer that is quick on d2 takes the way it moves for a disturbance, and the
    loop is lost, even with a machine that is the model. Without an observer a load leaves an offset. A jump
    of the demand is in no rate, and is met with all the command that K makes of it.
    """

    effort: Effort
    time_constant: SpoolTimeConstant
    observer: Observer
    force_weight: ForceWeight = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gain_1: VelocityGain = 0.0
    gain_2: ForceGain = 0.0
    gain_3: OpeningGain = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [
            valve_known(self.time_constant, facts),
            robust(facts),
            within_limit(facts),
        ]

    def init(self) -> OffsetFreeLQState:
        return OffsetFreeLQState(0.0, 0.0, self.observer.init())

    def step(self, s: OffsetFreeLQState, y: Measurement, r: Demand, dt: float) -> OffsetFreeLQState:
        spool = SpoolLag(self.time_constant).under_held_command(s.opening, y.command, dt)
        o = self.observer.step(s.observer, self.model, y.with_command(spool.mean), dt)
        law = StateFeedback(self.gain_1, self.gain_2, self.gain_3)
        u = law.command(self.model, o.velocity, o.hydraulic_force, spool.opening, o.d1, o.d2, r, 0.0)
        return OffsetFreeLQState(self.saturation.apply(u), spool.opening, o)

    def designed(self, model: DesignModel, period: float) -> "OffsetFreeLQ":
        """The law with its gains for a model and a sample period [s].

        Raises:
            ParameterError: there are none, or they are beyond the range of floating-point numbers.
        """
        k1, k2, k3 = feedback(self, RULING, model, period)
        return self._replace(gain_1=k1, gain_2=k2, gain_3=k3)
