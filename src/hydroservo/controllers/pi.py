"""Proportional-integral velocity control."""

from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.controllers.saturation import Saturation
from hydroservo.signals import Demand, Measurement

__all__ = ["PI", "PIState"]

PAPER = "doi:10.1007/s42401-021-00087-w, Sec. 4"


class PIState(NamedTuple):
    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]


class PI(NamedTuple):
    """u = sat(k_p e + k_i int e dt) with e the velocity error.

    With ``anti_windup`` k_aw > 0 the integral also follows the command that was really applied,
    d(integral)/dt = k_i e + k_aw (u_applied - u_unlimited): back-calculation.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w, which has no anti-windup (k_aw = 0); back-calculation from
    Astrom and Hagglund, Advanced PID Control, 2006, sec. 3.5.
    Fails with a slow valve: at T_sv = 10 ms the printed k_p = 100 V s/m is unstable, Routh allows 8.4.
    """

    proportional_gain: Annotated[float, Field("V s/m", "proportional gain k_p", PAPER, at_least=0)] = 100.0
    integral_gain: Annotated[float, Field("V/m", "integral gain k_i", PAPER, at_least=0)] = 10.0
    anti_windup: Annotated[
        float, Field("1/s", "back-calculation gain k_aw", "0: none, as in the paper", at_least=0)
    ] = 0.0
    saturation: Saturation = Saturation()

    def init(self) -> PIState:
        return PIState(0.0, 0.0, 0.0)

    def step(self, s: PIState, y: Measurement, r: Demand, dt: float) -> PIState:
        error = r.value - y.velocity
        correction = self.anti_windup * (y.command - s.unlimited)
        integral = s.integral + dt * (self.integral_gain * error + correction)
        unlimited = self.proportional_gain * error + integral
        return PIState(self.saturation.apply(unlimited), integral, unlimited)
