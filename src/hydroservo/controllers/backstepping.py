"""Backstepping on the nominal model: the paper's second rival."""

from typing import Annotated, NamedTuple

from hydroservo.block import Block, Field
from hydroservo.controlled.velocity import Velocity
from hydroservo.controllers.saturation import Saturation
from hydroservo.observers.model_derivative import ModelDerivative
from hydroservo.plants.design_model import THIS_MACHINE, DesignModel
from hydroservo.roles import Controller, Differentiator, controlling, role
from hydroservo.signals import Demand, Measurement

__all__ = ["Backstepping", "BacksteppingState"]


class BacksteppingState(NamedTuple):
    """The last command and errors, and the state of the nested derivative."""

    u: Annotated[float, Field("V", "command")]
    z1: Annotated[float, Field("m/s", "velocity error z1")]
    z2: Annotated[float, Field("N", "error of the virtual control z2 = x2 - zeta1")]
    derivative: Block


@role(Controller)
@controlling(Velocity)
class Backstepping(NamedTuple):
    """Two-step backstepping for the strict-feedback model, without disturbance estimates.

    With z1 = x1 - dy_d/dt, zeta1 the virtual control and z2 = x2 - zeta1::

        zeta1 = (-k1 z1 - f1 + d2y_d/dt2)/g1
        u     = (-k2 z2 - f2 - g1 z1 + dzeta1/dt)/g2

    dzeta1/dt comes from the nested block: analytic on the nominal model, or a filtered difference.

    Source: eq. (26) of doi:10.1007/s42401-021-00087-w, with the sign of its f1 and its z1 mended.
    Fails under load and parametric errors: with no integral action the velocity error they cause stays.
    """

    velocity_gain: Annotated[float, Field("1/s", "gain k1", above=0)]
    force_gain: Annotated[float, Field("1/s", "gain k2", above=0)]
    model: DesignModel = THIS_MACHINE
    derivative: Differentiator = ModelDerivative()
    saturation: Saturation = Saturation()

    def init(self) -> BacksteppingState:
        return BacksteppingState(0.0, 0.0, 0.0, self.derivative.init())

    def step(self, s: BacksteppingState, y: Measurement, r: Demand, dt: float) -> BacksteppingState:
        m = self.model
        x1, x2 = y.velocity, y.load_force
        f1, f1_slope, g1 = m.f1(x1), m.f1_slope(), m.g1()
        z1 = x1 - r.value
        zeta1 = (-self.velocity_gain * z1 - f1 + r.rate) * (1.0 / g1)
        acceleration = f1 + g1 * x2
        model_rate = (
            -self.velocity_gain * (acceleration - r.rate) - f1_slope * acceleration + r.second_rate
        ) * (1.0 / g1)
        derivative = self.derivative.step(s.derivative, zeta1, model_rate, dt)
        z2 = x2 - zeta1
        numerator = -self.force_gain * z2 - m.f2(x1, x2) - g1 * z1 + derivative.rate
        u = self.saturation.apply(numerator / m.g2(x2, y.command))
        return BacksteppingState(u, z1, z2, derivative)
