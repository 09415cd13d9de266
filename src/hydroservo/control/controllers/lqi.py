"""State feedback that is best by a quadratic measure, without offset by an integral."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.state_feedback import (
    COMPUTED,
    AntiWindupWeight,
    Effort,
    ForceGain,
    ForceWeight,
    IntegralRate,
    OpeningGain,
    SpoolTimeConstant,
    StateFeedback,
    VelocityGain,
)
from hydroservo.control.observers.spool_lag import SpoolLag
from hydroservo.control.synthesis.lqr import feedback
from hydroservo.control.synthesis.memory import integrator
from hydroservo.core.assumptions import Assumption, Facts, robust, valve_known, within_limit
from hydroservo.core.block import Field
from hydroservo.core.roles import Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

RULING = ("effort", "integral_rate", "force_weight", "time_constant")


class LQIState(NamedTuple):
    """The last command, the modelled spool and the integral."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    integral: Annotated[float, Field("m", "integral of velocity less demand, with anti-windup")]
    unlimited: Annotated[float, Field("V", "command before saturation")]


@role(Controller)
@controlling(Velocity)
class LQI(NamedTuple):
    """As OffsetFreeLQ, with an integral of the error in place of an observer and its disturbances.

    With x3 the modelled opening, e = x1 - r, and xr where the model alone would follow the demand::

        q := q + h (e - c (u_applied - u_unlimited))
        u  = sat( x3r - g2(0)/g2(x2, x3) (k1 e + k2 (x2 - x2r) + k4 q) - k3 (x3 - x3r) )

    K makes the sum over all samples of e^2 + (w (x2 - x2r))^2 + (w_q q)^2 + (rho (u - x3r))^2 least, with
    rho the ``effort``, w the ``force_weight`` and w_q the ``integral_rate``, for the model at rest with the
    valve's lag, sampled. With ``anti_windup`` c > 0 the integral also follows the command that was really
    applied: back-calculation, for c = 1/k1 that of Hanus. Velocity and hydraulic force are taken as measured.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 9.2 (the gain) and
    sec. 8.5 (the integral as a state); back-calculation: Astrom and Hagglund, Advanced PID Control, 2006,
    sec. 3.5.
    Fails as OffsetFreeLQ where little effort buys speed with robustness; a disturbance is met only when it
    has made an error; noise reaches the command unfiltered, by k1 and k2. Without anti-windup the integral
    winds up behind every limit.
    """

    effort: Effort
    integral_rate: IntegralRate
    time_constant: SpoolTimeConstant
    force_weight: ForceWeight = 0.0
    anti_windup: AntiWindupWeight = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gain_1: VelocityGain = 0.0
    gain_2: ForceGain = 0.0
    gain_3: OpeningGain = 0.0
    gain_4: Annotated[float, Field("V/m", "gain of the integral", COMPUTED, derived=True)] = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [
            valve_known(self.time_constant, facts),
            robust(facts),
            within_limit(facts),
        ]

    def init(self) -> LQIState:
        return LQIState(0.0, 0.0, 0.0, 0.0)

    def step(self, s: LQIState, y: Measurement, r: Demand, dt: float) -> LQIState:
        opening = SpoolLag(self.time_constant).after(s.opening, y.command, dt)
        law = StateFeedback(self.gain_1, self.gain_2, self.gain_3)
        remembered = self.gain_4 * s.integral
        u = law.command(self.model, y.velocity, y.hydraulic_force, opening, 0.0, 0.0, r, remembered)
        error = y.velocity - r.value - self.anti_windup * (y.command - s.unlimited)
        return LQIState(self.saturation.apply(u), opening, s.integral + dt * error, u)

    def designed(self, model: DesignModel, period: float) -> "LQI":
        """The law with its gains for a model and a sample period [s].

        Raises:
            ParameterError: there are none, or they are beyond the range of floating-point numbers.
        """
        k1, k2, k3, k4 = feedback(self, RULING, model, period, integrator(self.integral_rate, period))
        return self._replace(gain_1=k1, gain_2=k2, gain_3=k3, gain_4=k4)
