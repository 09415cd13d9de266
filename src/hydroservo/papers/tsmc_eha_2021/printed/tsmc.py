"""The terminal sliding mode law as eq. (22) prints it."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.tsmc import TSMCState
from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Controller, Differentiator, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.papers.tsmc_eha_2021.machine import COMMAND_LIMIT, MODEL, OBSERVER, SOURCE, TERMINAL


@role(Controller)
@controlling(Velocity)
class PrintedTSMC(NamedTuple):
    """Terminal sliding mode velocity control to the letter of the print.

    With a_i = p_i/q_i and every power odd (|x|^a sgn x)::

        xi1    = x1 - dy_d/dt + s1
        dxi1   = f1 + g1 x2 + d1 - d2y_d/dt2
        xi2    = dxi1 + mu1 xi1 + delta1 xi1^a1 + g1 s2 - b/m s1
        u      = -1/(g1 g2) [ -b/m (f1 + g1 x2 + d1) + g1 (f2 + d2) + d1 - d2y_d/dt2
                              + mu1 dxi1 + delta1 d(s1^a1)/dt + mu2 xi2 + delta2 xi2^a2 ]

    u has d1 where its derivative is meant, the second derivative of y_d for the third, and s1 for xi1 under
    the last derivative, which comes from the nested block. :class:`~hydroservo.control.controllers.TSMC`
    mends them.

    Source: eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w, in the text as it reached us.
    Fails where ``TSMC`` does. The study of the paper shows what its wrong terms cost under each condition:
    next to mu1 dxi1 they are often small.
    """

    linear_gain_1: Annotated[float, Field("1/s", "gain mu_1", SOURCE, above=0)] = TERMINAL.linear_gain_1
    linear_gain_2: Annotated[float, Field("1/s", "gain mu_2", SOURCE, above=0)] = TERMINAL.linear_gain_2
    power_gain_1: Annotated[
        float, Field("m^(2/7)/s^(9/7)", "gain delta_1 [(m/s)^(1-a1)/s]", SOURCE, at_least=0)
    ] = TERMINAL.power_gain_1
    power_gain_2: Annotated[
        float, Field("m^(4/9)/s^(17/9)", "gain delta_2 [(m/s^2)^(1-a2)/s]", SOURCE, at_least=0)
    ] = TERMINAL.power_gain_2
    exponent_1: Annotated[float, Field("", "exponent a1 = p_1/q_1", SOURCE, at_least=0.1, below=1)] = (
        TERMINAL.exponent_1
    )
    exponent_2: Annotated[float, Field("", "exponent a2 = p_2/q_2", SOURCE, at_least=0.1, below=1)] = (
        TERMINAL.exponent_2
    )
    model: DesignModel = MODEL
    observer: Observer = OBSERVER
    derivative: Differentiator = TERMINAL.derivative
    saturation: Saturation = COMMAND_LIMIT

    def init(self) -> TSMCState:
        return TSMCState(0.0, 0.0, 0.0, self.observer.init(), self.derivative.init())

    def step(self, s: TSMCState, y: Measurement, r: Demand, dt: float) -> TSMCState:
        m = self.model
        o = self.observer.step(s.observer, m, y, dt)
        x1, x2 = o.velocity, o.hydraulic_force
        g1, f1_slope = m.g1(), m.f1_slope()
        xi1 = x1 - r.value + o.s1
        acceleration = m.f1(x1) + g1 * x2 + o.d1
        xi1_rate = acceleration - r.rate
        pull = self.linear_gain_1 * xi1 + self.power_gain_1 * ops.signed_power(xi1, self.exponent_1)
        xi2 = xi1_rate + pull + g1 * o.s2 + f1_slope * o.s1
        derivative = self.derivative.step(s.derivative, ops.signed_power(o.s1, self.exponent_1), 0.0, dt)
        drift = (
            f1_slope * acceleration
            + g1 * (m.f2(x1, x2) + o.d2)
            + o.d1
            - r.rate
            + (self.linear_gain_1 * xi1_rate + self.power_gain_1 * derivative.rate)
            + (self.linear_gain_2 * xi2 + self.power_gain_2 * ops.signed_power(xi2, self.exponent_2))
        )
        u = self.saturation.apply(-drift * (1.0 / (g1 * m.g2(x2, y.command))))
        return TSMCState(u, xi1, xi2, o, derivative)
