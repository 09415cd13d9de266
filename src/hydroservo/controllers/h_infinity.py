"""H-infinity loop shaping: a PI law made as robust as it can be."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.controlled.velocity import Velocity
from hydroservo.controllers.biquad import Biquad, BiquadState
from hydroservo.controllers.saturation import Saturation
from hydroservo.errors import ParameterError
from hydroservo.plants.design_model import THIS_MACHINE, DesignModel
from hydroservo.roles import Controller, controlling, role
from hydroservo.signals import Demand, Measurement
from hydroservo.synthesis.coprime import robust_controller
from hydroservo.synthesis.loop_shaping import shaped_plant
from hydroservo.synthesis.sections import sections

__all__ = ["HInfinityLoopShaping", "HInfinityLoopShapingState"]

COMPUTED = "two Riccati equations"


class HInfinityLoopShapingState(NamedTuple):
    """The last command, the integral, and the sections of the filter."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]
    first: BiquadState
    second: BiquadState
    third: BiquadState


@role(Controller)
@controlling(Velocity)
class HInfinityLoopShaping(NamedTuple):
    """A PI law as a weight, and around it the controller that bears the largest uncertainty of the plant.

    The PI law shapes the loop: G_s = G (k_p + k_i/s), with G the design model about rest behind a valve of
    first order and half a sample of delay. The controller K_s of that is the one which stabilises all plants
    within 1/gamma of G_s, in normalised coprime factors, gamma = factor gamma_min; it is written as its gain
    at rest and a filter F of order five, in three sections, with F(0) = 1::

        e = K_s(0) (r - F y),   I := I + h (k_i e + k_aw (u_applied - u_unlimited))
        u = sat( k_p e + I )

    so that a demand passes no filter, and with an integral there is no error at rest. gamma below 2 to 3 says
    that the weight goes with the plant; beyond 4 or so it asks for more than the plant can give. All is
    computed before a run, for the model and the sample period; F is sampled by Tustin's rule.

    Source: McFarlane, Glover, IEEE Trans. Automatic Control 37(6), 1992; the demand by the gain at rest:
    Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, sec. 9.4.3; the plant: eqs. (6)-(7) of
    doi:10.1007/s42401-021-00087-w.
    Fails to gain much on a PI law that is robust already; to know of a valve of other order than the first;
    and where the sample period is long for the weight, so that half a sample is more than Pade's first order.
    """

    proportional_gain: Annotated[float, Field("V s/m", "proportional gain k_p of the weight", at_least=0)]
    integral_gain: Annotated[float, Field("V/m", "integral gain k_i of the weight", at_least=0)]
    valve_time_constant: Annotated[
        float, Field("s", "spool time constant T_sv; 0: a valve without lag", at_least=0)
    ]
    factor: Annotated[
        float, Field("", "gamma over the least there is", "Skogestad, Postlethwaite, sec. 9.4.1", above=1)
    ] = 1.1
    anti_windup: Annotated[
        float, Field("1/s", "back-calculation gain k_aw", "0: none, as in PI", at_least=0)
    ] = 0.0
    model: DesignModel = THIS_MACHINE
    saturation: Saturation = Saturation()
    gamma: Annotated[float, Field("", "gamma; 1/gamma is the stability margin", COMPUTED, derived=True)] = 0.0
    gain: Annotated[float, Field("", "gain at rest of the robust controller", COMPUTED, derived=True)] = 1.0
    first: Biquad = Biquad()
    second: Biquad = Biquad()
    third: Biquad = Biquad()

    def check(self) -> None:
        if self.proportional_gain == self.integral_gain == 0.0:
            raise ParameterError("proportional_gain", 0.0, "must be above 0 [V s/m] where integral_gain is 0")

    def init(self) -> HInfinityLoopShapingState:
        first, second, third = self.first.init(), self.second.init(), self.third.init()
        return HInfinityLoopShapingState(0.0, 0.0, 0.0, first, second, third)

    def step(
        self, s: HInfinityLoopShapingState, y: Measurement, r: Demand, dt: float
    ) -> HInfinityLoopShapingState:
        first = self.first.step(s.first, y.velocity)
        second = self.second.step(s.second, first.value)
        third = self.third.step(s.third, second.value)
        error = self.gain * (r.value - third.value)
        correction = self.anti_windup * (y.command - s.unlimited)
        integral = s.integral + dt * (self.integral_gain * error + correction)
        unlimited = self.proportional_gain * error + integral
        u = self.saturation.apply(unlimited)
        return HInfinityLoopShapingState(u, integral, unlimited, first, second, third)

    def designed(self, model: DesignModel, period: float) -> "HInfinityLoopShaping":
        """The law with its filter for a model and a sample period [s].

        Raises:
            ParameterError: there is no such controller, or it is unstable, or out of the reach of
                floating-point numbers.
        """
        k_p, k_i = self.proportional_gain, self.integral_gain
        try:
            found = robust_controller(
                shaped_plant(model, self.valve_time_constant, period, k_p, k_i), self.factor
            )
            gain, parts = sections(found.k)
        except ValueError as error:
            problem = (
                f"with integral_gain = {k_i:g}, valve_time_constant = {self.valve_time_constant:g} and a "
                f"sample period of {period:g} s there is no robust controller: {error}"
            )
            raise ParameterError("HInfinityLoopShaping.proportional_gain", k_p, problem) from None
        first, second, third = (*(Biquad(*part.sampled(period)) for part in parts), *[Biquad()] * 3)[:3]
        gamma = float(f"{found.gamma:.9g}")
        return self._replace(gamma=gamma, gain=gain, first=first, second=second, third=third)
