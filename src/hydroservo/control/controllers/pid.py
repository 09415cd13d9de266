"""Proportional, integral and derivative control with feedforward: the axis controller of industry."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.observers.filtered_derivative import FilteredDerivative, FilteredDerivativeState
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, half_of_largest, robust, within_limit
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement

EVERYWHERE = 1e30  # for an open integral_range, in any unit; finite, as parameters of FMUs must be


class PIDState(NamedTuple):
    """The last command, the integral, and the rate of the controlled signal."""

    u: Annotated[float, Field("V", "command")]
    integral: Annotated[float, Field("V", "integral part of the command")]
    unlimited: Annotated[float, Field("V", "command before saturation")]
    derivative: FilteredDerivativeState


@role(Controller)
class PID(NamedTuple):
    """PI with derivative feedback, feedforward of the demand and its rates, and an integrator with a range.

    u = sat(k_0 r + k_1 r' + k_2 r'' + k_p e + I - k_d y'),  e = r - y

    dI/dt = (k_i e where dead_zone <= |e| <= integral_range, else 0) + k_aw (u_applied - u_unlimited),
    and |I| <= integral_limit. The rate y' is that of the measured signal through a low-pass, so that a demand
    which jumps gives no impulse; with k_1 raised by k_d it is the rate of the error that is fed back.

    In a position loop k_1 is the velocity feedforward and k_2 the acceleration feedforward; in a velocity
    loop these are k_0 and k_1. An axis that moves at K_v per volt follows a ramp without error when its
    velocity feedforward is 1/K_v + k_d. Without what stands at 0 by default it is a P law, and gives the
    bits of PI.

    Source: the axis controllers of Moog ACV with CANopen bus interface, user manual B99224-DV018-D-211, Rev.
    A, 2018, sec. 7.8 and 7.10 (feedforward gains, an integrator with inner and outer range and a limit);
    back-calculation: Astrom and Hagglund, Advanced PID Control, 2006, sec. 3.5.
    Fails where the feedforward is of a machine that has changed, by the change; with a derivative of a signal
    whose steps of resolution are coarse; and inside a dead zone that is wider than what is asked for. In
    a position loop a proportional gain beyond 2 zeta_h omega_h/K_v is unstable where valve and sampling are
    much faster than the axis: damp the axis first, see PressureFeedback and AccelerationFeedback.
    """

    proportional_gain: Annotated[float, Field("V/y", "proportional gain k_p", at_least=0)]
    integral_gain: Annotated[float, Field("V/(y s)", "integral gain k_i", "0: none", at_least=0)] = 0.0
    derivative_gain: Annotated[float, Field("V s/y", "derivative gain k_d", "0: none", at_least=0)] = 0.0
    feedforward: Annotated[float, Field("V/y", "of the {y} demand, k_0", "0: none")] = 0.0
    rate_feedforward: Annotated[float, Field("V s/y", "of the demand's rate, k_1", "0: none")] = 0.0
    second_rate_feedforward: Annotated[
        float, Field("V s^2/y", "of the demand's second rate, k_2", "0: none")
    ] = 0.0
    integral_limit: Annotated[
        float, Field("V", "largest integral part of the command", "Saturation's limit", above=0)
    ] = 10.0
    integral_range: Annotated[
        float, Field("y", "largest error that is integrated", "all are", above=0, auto=EVERYWHERE)
    ] = EVERYWHERE
    dead_zone: Annotated[float, Field("y", "least error that is integrated", "0: all are", at_least=0)] = 0.0
    anti_windup: Annotated[
        float, Field("1/s", "back-calculation gain k_aw", "0: none, as in PI", at_least=0)
    ] = 0.0
    derivative: FilteredDerivative = FilteredDerivative()
    saturation: Saturation = Saturation()
    controls: ControlledSignal = THIS_SIGNAL

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        reserve = half_of_largest(self.proportional_gain, self.controls.declared().unit, facts)
        return [robust(facts), *reserve, within_limit(facts)]

    def check(self) -> None:
        if not self.dead_zone < self.integral_range:
            allowed = f"must be below integral_range, {self.integral_range:g}"
            raise ParameterError("dead_zone", self.dead_zone, allowed)

    def init(self) -> PIDState:
        return PIDState(0.0, 0.0, 0.0, self.derivative.init())

    def step(self, s: PIDState, y: Measurement, r: Demand, dt: float) -> PIDState:
        signal = self.controls.of(y, y.command)
        derivative = self.derivative.step(s.derivative, signal, 0.0, dt)
        error = r.value - signal
        integral = self.integrated(s, error, y.command, dt)
        unlimited = self.proportional_gain * error + integral
        unlimited += self.ahead(r) - self.derivative_gain * derivative.rate
        return PIDState(self.saturation.apply(unlimited), integral, unlimited, derivative)

    def integrated(self, s: PIDState, error: float, applied: float, dt: float) -> float:
        """The integral part at this sample [V]."""
        size = ops.absolute(error)
        counts = size >= self.dead_zone and size <= self.integral_range
        correction = self.anti_windup * (applied - s.unlimited)
        integral = s.integral + dt * (self.integral_gain * ops.where(counts, error, 0.0) + correction)
        return ops.clip(integral, -self.integral_limit, self.integral_limit)

    def ahead(self, r: Demand) -> float:
        """What the demand alone asks for [V]."""
        return (
            self.feedforward * r.value
            + self.rate_feedforward * r.rate
            + self.second_rate_feedforward * r.second_rate
        )
