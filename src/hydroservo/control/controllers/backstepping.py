"""Backstepping on the nominal model: the paper's second rival."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.observers.model_derivative import ModelDerivative
from hydroservo.control.observers.no_observer import NoObserver
from hydroservo.core.assumptions import Assumption, Facts, above, sampled_faster, valve_faster
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Differentiator, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel


class BacksteppingState(NamedTuple):
    """The last command and errors, and the states of the nested derivative and observer."""

    u: Annotated[float, Field("V", "command")]
    z1: Annotated[float, Field("m/s", "velocity less demand, z1")]
    z2: Annotated[float, Field("N", "error of the virtual control z2 = x2 - zeta1")]
    derivative: Block
    observer: Block


@role(Controller)
@controlling(Velocity)
class Backstepping(NamedTuple):
    """Two-step backstepping for the strict-feedback model, with the disturbances that an observer knows.

    With z1 = x1 - dy_d/dt, zeta1 the virtual control and z2 = x2 - zeta1::

        zeta1 = (-k1 z1 - f1 - d1 + d2y_d/dt2)/g1
        u     = (-k2 z2 - f2 - d2 - g1 z1 + dzeta1/dt)/g2

    dzeta1/dt comes from the nested block: analytic on the nominal model with d1 constant, or a filtered
    difference. x1, x2, d1 and d2 are as the nested ``observer`` hands them on; without one the disturbances
    are 0. With the analytic derivative it is :class:`Inverting` with a
    :class:`~hydroservo.control.error_dynamics.LinearErrorDynamics`, but for the term g1 z1.

    Source: eq. (26) of doi:10.1007/s42401-021-00087-w, with the sign of its f1 and its z1 mended; with an
    observer: Won, Kim, Shin, Chung, IEEE Trans. Control Systems Technology 23(2), 2015 (unverified).
    Fails under load and parametric errors without an observer: the velocity error they cause stays.
    """

    velocity_gain: Annotated[float, Field("1/s", "gain k1", above=0)]
    force_gain: Annotated[float, Field("1/s", "gain k2", above=0)]
    model: DesignModel = THIS_MACHINE
    derivative: Differentiator = ModelDerivative()
    saturation: Saturation = Saturation()
    observer: Observer = NoObserver()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        fastest = max(self.velocity_gain, self.force_gain)
        found = [
            sampled_faster(fastest, facts, "the larger of k1 and k2"),
            valve_faster(fastest, facts, "the larger of k1 and k2"),
        ]
        k, truth, model = self.velocity_gain * self.force_gain, facts.truth, facts.model
        if truth is None or not isinstance(self.observer, NoObserver):
            return found
        gamma = truth.g1() * truth.g2(0.0, 0.0) / (model.g1() * model.g2(0.0, 0.0))
        beta = truth.g1() * truth.f2(1.0, 0.0) / (model.g1() * model.f2(1.0, 0.0))
        softer = -model.g1() * model.f2(1.0, 0.0) * max(gamma - beta, 0.0) / gamma
        meaning = "k1 k2 is above omega_h^2 (gamma - beta)/gamma, which the cancelled stiffness drives"
        return [*found, above("stiffness cancelled", meaning, k, softer, "1/s^2")]

    def init(self) -> BacksteppingState:
        return BacksteppingState(0.0, 0.0, 0.0, self.derivative.init(), self.observer.init())

    def step(self, s: BacksteppingState, y: Measurement, r: Demand, dt: float) -> BacksteppingState:
        m = self.model
        o = self.observer.step(s.observer, m, y, dt)
        x1, x2 = o.velocity, o.hydraulic_force
        f1, f1_slope, g1 = m.f1(x1), m.f1_slope(), m.g1()
        z1 = x1 - r.value
        zeta1 = (-self.velocity_gain * z1 - f1 - o.d1 + r.rate) * (1.0 / g1)
        acceleration = f1 + g1 * x2 + o.d1
        model_rate = (
            -self.velocity_gain * (acceleration - r.rate) - f1_slope * acceleration + r.second_rate
        ) * (1.0 / g1)
        derivative = self.derivative.step(s.derivative, zeta1, model_rate, dt)
        z2 = x2 - zeta1
        numerator = -self.force_gain * z2 - m.f2(x1, x2) - o.d2 - g1 * z1 + derivative.rate
        u = self.saturation.apply(numerator / m.g2(x2, y.command))
        return BacksteppingState(u, z1, z2, derivative, o)
