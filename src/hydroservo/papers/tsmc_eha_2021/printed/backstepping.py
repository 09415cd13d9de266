"""Backstepping as eq. (26) prints it."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Differentiator, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.papers.tsmc_eha_2021.machine import BACKSTEPPING, COMMAND_LIMIT, MODEL, SOURCE


class PrintedBacksteppingState(NamedTuple):
    """The last command and errors, the demand's integral, and the state of the nested derivative."""

    u: Annotated[float, Field("V", "command")]
    z1: Annotated[float, Field("m/s", "error z1 = x1 - y_d, whose units do not match")]
    z2: Annotated[float, Field("N", "error of the virtual control z2 = x2 - zeta1")]
    demand_position: Annotated[float, Field("m", "y_d, the integral of the demand")]
    derivative: Block


@role(Controller)
@controlling(Velocity)
class PrintedBackstepping(NamedTuple):
    """Two-step backstepping to the letter of the print.

    With z1 = x1 - y_d, f1 = +b x1/m, zeta1 the virtual control and z2 = x2 - zeta1::

        zeta1 = (-k1 z1 - f1 + d2y_d/dt2)/g1
        u     = (-k2 z2 - f2 - g1 z1 + dzeta1/dt)/g2

    y_d is the integral of the demand, so that a velocity follows a position; f1 has the wrong sign.
    :class:`~hydroservo.control.controllers.Backstepping` mends both. dzeta1/dt comes from the nested block.

    Source: eq. (26) of doi:10.1007/s42401-021-00087-w.
    Fails to track: z1 is the difference of a velocity and a position.
    """

    velocity_gain: Annotated[float, Field("1/s", "gain k1", SOURCE, above=0)] = BACKSTEPPING.velocity_gain
    force_gain: Annotated[float, Field("1/s", "gain k2", SOURCE, above=0)] = BACKSTEPPING.force_gain
    model: DesignModel = MODEL
    derivative: Differentiator = BACKSTEPPING.derivative
    saturation: Saturation = COMMAND_LIMIT

    def init(self) -> PrintedBacksteppingState:
        return PrintedBacksteppingState(0.0, 0.0, 0.0, 0.0, self.derivative.init())

    def step(
        self, s: PrintedBacksteppingState, y: Measurement, r: Demand, dt: float
    ) -> PrintedBacksteppingState:
        m = self.model
        x1, x2 = y.velocity, y.hydraulic_force
        f1, f1_slope, g1 = -m.f1(x1), -m.f1_slope(), m.g1()
        z1 = x1 - s.demand_position
        zeta1 = (-self.velocity_gain * z1 - f1 + r.rate) * (1.0 / g1)
        acceleration = f1 + g1 * x2
        z1_rate = acceleration - r.value
        model_rate = (-self.velocity_gain * z1_rate - f1_slope * acceleration + r.second_rate) * (1.0 / g1)
        derivative = self.derivative.step(s.derivative, zeta1, model_rate, dt)
        z2 = x2 - zeta1
        numerator = -self.force_gain * z2 - m.f2(x1, x2) - g1 * z1 + derivative.rate
        u = self.saturation.apply(numerator / m.g2(x2, y.command))
        return PrintedBacksteppingState(u, z1, z2, s.demand_position + dt * r.value, derivative)
