"""State feedback that is best by a quadratic measure, without offset by an integral."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.controlled.velocity import Velocity
from hydroservo.controllers.saturation import Saturation
from hydroservo.controllers.spool_lag import SpoolLag
from hydroservo.controllers.state_feedback import StateFeedback
from hydroservo.plants.design_model import THIS_MACHINE, DesignModel
from hydroservo.roles import Controller, controlling, role
from hydroservo.signals import Demand, Measurement
from hydroservo.synthesis.lqr import feedback
from hydroservo.synthesis.memory import integrator

__all__ = ["LQI", "LQIState"]

COMPUTED = "a Riccati equation"
RULING = ("effort", "integral_rate", "force_weight", "time_constant")


class LQIState(NamedTuple):
    """The last command, the modelled spool and the integral."""

    u: Annotated[float, Field("V", "command")]
    opening: Annotated[float, Field("V", "modelled opening, as the command that would hold it")]
    integral: Annotated[float, Field("m", "integral of the velocity's error, with anti-windup")]
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
    applied: back-calculation, for c = 1/k1 that of Hanus. Velocity and load force are taken as measured.

    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, sec. 9.2 (the gain) and
    sec. 8.5 (the integral as a state); back-calculation: Astrom and Hagglund, Advanced PID Control, 2006,
    sec. 3.5.
    Fails as OffsetFreeLQ where little effort buys speed with robustness; a disturbance is met only when it
    has made an error; noise reaches the command unfiltered, by k1 and k2. Without anti-windup the integral
    winds up behind every limit.
    """

    effort: Annotated[float, Field("m/(s V)", "velocity error that a volt of command counts for", above=0)]
    integral_rate: Annotated[
        float, Field("1/s", "velocity error that a metre of its integral counts for", above=0)
    ]
    time_constant: Annotated[float, Field("s", "modelled spool time constant; 0: no lag", at_least=0)]
    force_weight: Annotated[
        float,
        Field("m/(s N)", "velocity error that a newton off its target counts for", "0: none", at_least=0),
    ] = 0.0
    anti_windup: Annotated[
        float,
        Field("m/(s V)", "velocity error that a volt not applied counts for", "0: none, as PI", at_least=0),
    ] = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gain_1: Annotated[float, Field("V s/m", "gain of the velocity", COMPUTED, derived=True)] = 0.0
    gain_2: Annotated[float, Field("V/N", "gain of the load force", COMPUTED, derived=True)] = 0.0
    gain_3: Annotated[float, Field("", "gain of the opening", COMPUTED, derived=True)] = 0.0
    gain_4: Annotated[float, Field("V/m", "gain of the integral", COMPUTED, derived=True)] = 0.0

    def init(self) -> LQIState:
        return LQIState(0.0, 0.0, 0.0, 0.0)

    def step(self, s: LQIState, y: Measurement, r: Demand, dt: float) -> LQIState:
        opening = SpoolLag(self.time_constant).after(s.opening, y.command, dt)
        law = StateFeedback(self.gain_1, self.gain_2, self.gain_3)
        remembered = self.gain_4 * s.integral
        u = law.command(self.model, y.velocity, y.load_force, opening, 0.0, 0.0, r, remembered)
        error = y.velocity - r.value - self.anti_windup * (y.command - s.unlimited)
        return LQIState(self.saturation.apply(u), opening, s.integral + dt * error, u)

    def designed(self, model: DesignModel, period: float) -> "LQI":
        """The law with its gains for a model and a sample period [s].

        Raises:
            ParameterError: there are none, or they are out of the reach of floating-point numbers.
        """
        k1, k2, k3, k4 = feedback(self, RULING, model, period, integrator(self.integral_rate, period))
        return self._replace(gain_1=k1, gain_2=k2, gain_3=k3, gain_4=k4)
