"""Terminal sliding mode control with a disturbance observer: the paper's law."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.velocity import Velocity
from hydroservo.control.controllers.inverting import Inverting, InvertingState
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.error_dynamics.explicit_reaching import ExplicitReaching
from hydroservo.control.error_dynamics.terminal import TerminalErrorDynamics, TerminalErrorDynamicsState
from hydroservo.control.observers.filtered_derivative import FilteredDerivative
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Differentiator, Observer, Reaching, controlling, role
from hydroservo.core.signals import Demand, Measurement
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel


class TSMCState(NamedTuple):
    """The last command and surfaces, and the states of the nested observer and derivative."""

    u: Annotated[float, Field("V", "command")]
    xi1: Annotated[float, Field("m/s", "sliding surface xi1")]
    xi2: Annotated[float, Field("m/s^2", "sliding surface xi2")]
    observer: Block
    derivative: Block


@role(Controller)
@controlling(Velocity)
class TSMC(NamedTuple):
    """Terminal sliding mode velocity control on the nominal model and the observer's estimates.

    With a_i = p_i/q_i and every power odd (|x|^a sgn x)::

        xi1    = x1 - dy_d/dt + s1
        dxi1   = f1 + g1 x2 + d1 - d2y_d/dt2
        xi2    = dxi1 + mu1 xi1 + delta1 xi1^a1 + g1 s2 - b/m s1
        u      = -1/(g1 g2) [ -b/m (f1 + g1 x2 + d1) + g1 (f2 + d2) + dd1/dt - d3y_d/dt3
                              + mu1 dxi1 + delta1 d(xi1^a1)/dt + mu2 xi2 + delta2 xi2^a2 ]

    d(xi1^a1)/dt = a1 |xi1|^(a1-1) dxi1 is singular in the print at xi1 = 0; how the powers of xi1 and xi2 are
    realised in discrete time is the nested ``reaching``. dd1/dt comes from a nested derivative block. x1 and
    x2 are as the observer hands them on.

    Source: eqs. (19)-(22) of doi:10.1007/s42401-021-00087-w, with the slips of (22) mended.
    Fails where sgn is explicit (the derivative of a switching estimate reaches u, which chatters), where
    the valve lags by more than about 1/mu1, and where mu1 times the sample period nears 1.
    """

    linear_gain_1: Annotated[float, Field("1/s", "gain mu_1", above=0)]
    linear_gain_2: Annotated[float, Field("1/s", "gain mu_2", above=0)]
    power_gain_1: Annotated[float, Field("m^(2/7)/s^(9/7)", "gain delta_1 [(m/s)^(1-a1)/s]", at_least=0)]
    power_gain_2: Annotated[float, Field("m^(4/9)/s^(17/9)", "gain delta_2 [(m/s^2)^(1-a2)/s]", at_least=0)]
    exponent_1: Annotated[float, Field("", "exponent a1 = p_1/q_1", at_least=0.1, below=1)]
    exponent_2: Annotated[float, Field("", "exponent a2 = p_2/q_2", at_least=0.1, below=1)]
    observer: Observer
    model: DesignModel = THIS_MACHINE
    derivative: Differentiator = FilteredDerivative()
    saturation: Saturation = Saturation()
    reaching: Reaching = ExplicitReaching()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return TerminalErrorDynamics(*self[:6], self.reaching).assumptions(facts)

    def init(self) -> TSMCState:
        return TSMCState(0.0, 0.0, 0.0, self.observer.init(), self.derivative.init())

    def step(self, s: TSMCState, y: Measurement, r: Demand, dt: float) -> TSMCState:
        dynamics = TerminalErrorDynamics(*self[:6], self.reaching)
        law = Inverting(dynamics, self.observer, self.model, self.derivative, self.saturation)
        surfaces = TerminalErrorDynamicsState(0.0, 0.0, s.xi1, s.xi2)
        last = InvertingState(s.u, surfaces, s.observer, s.derivative)
        now = law.step(last, y, r, dt)
        return TSMCState(now.u, now.error_dynamics.xi1, now.error_dynamics.xi2, now.observer, now.derivative)
