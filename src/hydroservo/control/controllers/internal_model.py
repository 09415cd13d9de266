"""State feedback with a model of what makes demand and load: an integrator and an oscillator."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.resonator import Resonator, ResonatorState
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
from hydroservo.control.synthesis.memory import both, integrator, oscillator
from hydroservo.core.assumptions import Assumption, Facts, near, robust, valve_known, within_limit
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

RULING = ("effort", "frequency", "integral_rate", "resonant_rate", "force_weight", "time_constant")


class InternalModelState(NamedTuple):
    """The last command, the modelled spool, the integral and the oscillator."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    integral: Annotated[float, Field("m", "integral of velocity less demand, with anti-windup")]
    resonator: ResonatorState
    unlimited: Annotated[float, Field("V", "command before saturation")]


@role(Controller)
@controlling(Velocity)
class InternalModel(NamedTuple):
    """LQI with an oscillator beside the integrator: it knows the frequency of what disturbs it.

    With x3 the modelled opening, e = x1 - r - c (u_applied - u_unlimited), R the rotation by 2 pi f h, and
    xr where the model alone would follow the demand::

        q := q + h e,   m := R (m + [0, h e]),   v = k4 q + k5 m1 + k6 m2
        u  = sat( x3r - g2(0)/g2(x2, x3) (k1 (x1 - r) + k2 (x2 - x2r) + v) - k3 (x3 - x3r) )

    K makes the sum over all samples of (x1 - r)^2 + (w (x2 - x2r))^2 + (w_q q)^2 + w_m^2 (m1^2 + m2^2) +
    (rho (u - x3r))^2 least, for the model at rest with the valve's lag, sampled. Of a constant, and of a sine
    of the ``frequency``, in demand and load no error stays as long as the loop is stable, whatever the
    machine's parameters: the loop's gain there has no bound.

    Source: Francis, Wonham, Automatica 12(5), 1976 (the principle); as resonant states of a linear quadratic
    design: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 8.4.
    Fails at other frequencies, where an error stays, the larger the further off; at most of them it is little
    better than LQI, and what it gains at its own it loses elsewhere. It rings after a jump, for about the
    time that ``resonant_rate`` sets. Harmonics that a nonlinear machine makes stay. And as LQI.
    """

    effort: Effort
    frequency: Annotated[float, Field("Hz", "frequency of demand and load", above=0)]
    integral_rate: IntegralRate
    resonant_rate: Annotated[
        float, Field("1/s", "velocity error that a metre of the oscillator counts for", above=0)
    ]
    time_constant: SpoolTimeConstant
    force_weight: ForceWeight = 0.0
    anti_windup: AntiWindupWeight = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gain_1: VelocityGain = 0.0
    gain_2: ForceGain = 0.0
    gain_3: OpeningGain = 0.0
    gain_4: Annotated[float, Field("V/m", "gain of the integral", COMPUTED, derived=True)] = 0.0
    gain_5: Annotated[float, Field("V/m", "gain of the oscillator behind", COMPUTED, derived=True)] = 0.0
    gain_6: Annotated[float, Field("V/m", "gain of the oscillator in phase", COMPUTED, derived=True)] = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        meaning = "frequency is within 1 % of that of the demand"
        return [
            near("frequency known", meaning, self.frequency, facts.demand_frequency, 1.01, "Hz"),
            valve_known(self.time_constant, facts),
            robust(facts),
            within_limit(facts),
        ]

    def init(self) -> InternalModelState:
        return InternalModelState(0.0, 0.0, 0.0, Resonator(self.frequency).init(), 0.0)

    def step(self, s: InternalModelState, y: Measurement, r: Demand, dt: float) -> InternalModelState:
        opening = SpoolLag(self.time_constant).after(s.opening, y.command, dt)
        law = StateFeedback(self.gain_1, self.gain_2, self.gain_3)
        m = s.resonator
        remembered = self.gain_4 * s.integral + self.gain_5 * m.quarter + self.gain_6 * m.phase
        u = law.command(self.model, y.velocity, y.hydraulic_force, opening, 0.0, 0.0, r, remembered)
        error = y.velocity - r.value - self.anti_windup * (y.command - s.unlimited)
        resonator = Resonator(self.frequency).step(m, error, dt)
        return InternalModelState(self.saturation.apply(u), opening, s.integral + dt * error, resonator, u)

    def designed(self, model: DesignModel, period: float) -> "InternalModel":
        """The law with its gains for a model and a sample period [s].

        Raises:
            ParameterError: the frequency is not below half that of sampling; there are no gains, or they are
                beyond the range of floating-point numbers.
        """
        if not self.frequency < 0.5 / period:
            allowed = f"must be below half the sampling frequency, {0.5 / period:g} [Hz]"
            raise ParameterError("InternalModel.frequency", self.frequency, allowed)
        memory = both(
            integrator(self.integral_rate, period), oscillator(self.resonant_rate, self.frequency, period)
        )
        k1, k2, k3, k4, k5, k6 = feedback(self, RULING, model, period, memory)
        return self._replace(gain_1=k1, gain_2=k2, gain_3=k3, gain_4=k4, gain_5=k5, gain_6=k6)
