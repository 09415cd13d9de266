"""The frame of most laws of relative degree two: error dynamics, an observer, and the model inverted."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.error_dynamics.linear import LinearErrorDynamics
from hydroservo.control.observers.filtered_derivative import FilteredDerivative
from hydroservo.control.observers.no_observer import NoObserver
from hydroservo.core.assumptions import Assumption, Facts, above
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Differentiator, ErrorDynamics, Observer, controlling, role
from hydroservo.core.signals import Demand, Measurement, VelocityError
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel


class InvertingState(NamedTuple):
    """The last command, and the states of error dynamics, observer and derivative."""

    u: Annotated[float, Field("V", "command")]
    error_dynamics: Block
    observer: Block
    derivative: Block


@role(Controller)
@controlling(Velocity)
class Inverting(NamedTuple):
    """The design model inverted, so that the velocity's error follows the nested ``error_dynamics``.

    With x1, x2, d1 and d2 as the nested ``observer`` hands them on, e = x1 - r + s1::

        a = f1 + g1 x2 + d1,   de/dt = a - r'
        u = sat( (r'' - q(e, de/dt) - f1' a - g1 (f2 + d2) - dd1/dt) / (g1 g2) )

    so that e'' = -q but for what the estimates miss. dd1/dt is the nested ``derivative`` of the estimate; s1
    and s2 are the observer's surfaces, 0 for most, which shift that of the error dynamics by
    s' = g1 s2 + f1' s1. Feedback linearisation, backstepping and the sliding mode laws differ in their error
    dynamics and their observer.

    Source: Isidori, Nonlinear Control Systems, 1995, ch. 4 (inversion); with a disturbance observer: Chen,
    Ballance, Gawthrop, O'Reilly, IEEE Trans. Industrial Electronics 47(4), 2000 (unverified).
    Fails where the valve is slower than the error dynamics (ValveInversion helps), and where the model's oil
    is softer than the machine's and no observer makes up for it: its stiffness is cancelled by positive
    feedback.
    """

    error_dynamics: ErrorDynamics
    observer: Observer
    model: DesignModel = THIS_MACHINE
    derivative: Differentiator = FilteredDerivative()
    saturation: Saturation = Saturation()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        error, truth, model = self.error_dynamics, facts.truth, facts.model
        observed = not isinstance(self.observer, NoObserver)
        if truth is None or observed or not isinstance(error, LinearErrorDynamics):
            return []
        gamma = truth.g1() * truth.g2(0.0, 0.0) / (model.g1() * model.g2(0.0, 0.0))
        beta = truth.g1() * truth.f2(1.0, 0.0) / (model.g1() * model.f2(1.0, 0.0))
        softer = -model.g1() * model.f2(1.0, 0.0) * max(gamma - beta, 0.0) / gamma
        meaning = "k1 k2 is above omega_h^2 (gamma - beta)/gamma, which the cancelled stiffness drives"
        return [above("stiffness cancelled", meaning, error.first_pole * error.second_pole, softer, "1/s^2")]

    def init(self) -> InvertingState:
        return InvertingState(0.0, self.error_dynamics.init(), self.observer.init(), self.derivative.init())

    def step(self, s: InvertingState, y: Measurement, r: Demand, dt: float) -> InvertingState:
        m = self.model
        o = self.observer.step(s.observer, m, y, dt)
        x1, x2 = o.velocity, o.hydraulic_force
        g1, f1_slope = m.g1(), m.f1_slope()
        acceleration = m.f1(x1) + g1 * x2 + o.d1
        error = VelocityError(x1 - r.value + o.s1, acceleration - r.rate, g1 * o.s2, f1_slope * o.s1)
        jerk = self.error_dynamics.step(s.error_dynamics, error, dt)
        derivative = self.derivative.step(s.derivative, o.d1, 0.0, dt)
        drift = (
            f1_slope * acceleration
            + g1 * (m.f2(x1, x2) + o.d2)
            + derivative.rate
            - r.second_rate
            + jerk.damping
            + jerk.restoring
        )
        u = self.saturation.apply(-drift * (1.0 / (g1 * m.g2(x2, y.command))))
        return InvertingState(u, jerk, o, derivative)
