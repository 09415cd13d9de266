"""Two poles, and an integral where it is asked for: feedback linearisation, backstepping."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core.assumptions import Assumption, Facts, robust, sampled_faster, valve_faster
from hydroservo.core.block import Field
from hydroservo.core.roles import ErrorDynamics, role
from hydroservo.core.signals import VelocityError


class LinearErrorDynamicsState(NamedTuple):
    """What is asked for at this sample, and the integral."""

    damping: Annotated[float, Field("m/s^3", "jerk asked against the error's rate")]
    restoring: Annotated[float, Field("m/s^3", "jerk asked against the error")]
    integral: Annotated[float, Field("m", "integral of the error")]


@role(ErrorDynamics)
class LinearErrorDynamics(NamedTuple):
    """The error of a linear system with two poles.

    With sigma = de/dt + k1 e + s', s' the shift by the observer's surfaces::

        q = k1 de/dt + k2 sigma + k_I integral(e)

    so that, but for what the model misses, e'' + (k1 + k2) e' + k1 k2 e = 0: poles at -k1 and -k2. In
    :class:`~hydroservo.control.controllers.Inverting` this is feedback linearisation, and backstepping but
    for its cross term, whose effect on this machine is g1^2 against k1 k2.

    Source: Isidori, Nonlinear Control Systems, 1995, ch. 4 (feedback linearisation); the same poles by
    backstepping: Krstic, Kanellakopoulos, Kokotovic, Nonlinear and Adaptive Control Design, 1995, ch. 2.
    Fails without an observer: a load d_L1 leaves the error d_L1 (1/k1 + 1/k2), and where oil is stiffer than
    modelled small gains are unstable. With an integral it overshoots steps of the demand.
    """

    first_pole: Annotated[float, Field("1/s", "decay rate k1", above=0)]
    second_pole: Annotated[float, Field("1/s", "decay rate k2", above=0)]
    integral_gain: Annotated[float, Field("1/s^3", "integral gain k_I", "0: none", at_least=0)] = 0.0

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        fastest = max(self.first_pole, self.second_pole)
        return [
            robust(facts),
            sampled_faster(fastest, facts, "the faster pole"),
            valve_faster(fastest, facts, "the faster pole"),
        ]

    def init(self) -> LinearErrorDynamicsState:
        return LinearErrorDynamicsState(0.0, 0.0, 0.0)

    def step(self, s: LinearErrorDynamicsState, error: VelocityError, dt: float) -> LinearErrorDynamicsState:
        integral = s.integral + dt * error.value
        sigma = error.rate + self.first_pole * error.value + error.shift()
        restoring = self.second_pole * sigma + self.integral_gain * integral
        return LinearErrorDynamicsState(self.first_pole * error.rate, restoring, integral)
