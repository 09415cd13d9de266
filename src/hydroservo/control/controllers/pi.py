"""Proportional-integral control."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.assumptions import Assumption, Facts, half_of_largest, robust, within_limit
from hydroservo.core.block import Field
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement


class PIState(NamedTuple):
    """The last command and the integral."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]


@role(Controller)
class PI(NamedTuple):
    """u = sat(k_p e + k_i int e dt) with e = r - y the error of the signal that the loop controls.

    With ``anti_windup`` k_aw > 0 the integral also follows the command that was really applied,
    d(integral)/dt = k_i e + k_aw (u_applied - u_unlimited): back-calculation.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w, without anti-windup (k_aw = 0);
    back-calculation: Astrom and Hagglund, Advanced PID Control, 2006, sec. 3.5.
    Fails with a slow valve: with a lag of 10 ms Routh allows far less than the printed k_p; see
    hydroservo.machine.theory.proportional_gain_limit.
    """

    proportional_gain: Annotated[float, Field("V/y", "proportional gain k_p", at_least=0)]
    integral_gain: Annotated[float, Field("V/(y s)", "integral gain k_i", "0: a P law", at_least=0)] = 0.0
    anti_windup: Annotated[
        float, Field("1/s", "back-calculation gain k_aw", "0: none, as in the paper", at_least=0)
    ] = 0.0
    saturation: Saturation = Saturation()
    controls: ControlledSignal = THIS_SIGNAL

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        reserve = half_of_largest(self.proportional_gain, self.controls.declared().unit, facts)
        return [robust(facts), *reserve, within_limit(facts)]

    def init(self) -> PIState:
        return PIState(0.0, 0.0, 0.0)

    def step(self, s: PIState, y: Measurement, r: Demand, dt: float) -> PIState:
        error = r.value - self.controls.of(y, y.command)
        correction = self.anti_windup * (y.command - s.unlimited)
        integral = s.integral + dt * (self.integral_gain * error + correction)
        unlimited = self.proportional_gain * error + integral
        return PIState(self.saturation.apply(unlimited), integral, unlimited)
