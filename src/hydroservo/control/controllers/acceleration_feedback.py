"""Acceleration feedback around any law."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.observers.filtered_derivative import FilteredDerivative, FilteredDerivativeState
from hydroservo.core.assumptions import Assumption, Facts, valve_damps
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class AccelerationFeedbackState(NamedTuple):
    """What is put out, what of it is fed back, and the acceleration."""

    u: Annotated[float, Field("V", "command")]
    fed_back: Annotated[float, Field("V", "what the acceleration took off the command")]
    derivative: FilteredDerivativeState
    controller: Block


@role(Controller)
class AccelerationFeedback(NamedTuple):
    """The command of a nested law, less the measured velocity's rate: damping without pressure sensors.

    u = sat(u_law - k_a a),  a: the difference of the measured velocity through a low-pass of first order

    With a valve that is faster than the axis it adds K_v k_a omega_h/2 to the damping ratio, K_v [m/(s V)]
    the velocity per command. The nested law learns of the applied command without what was fed back.

    Source: Moog ACV with CANopen bus interface, user manual B99224-DV018-D-211, Rev. A, 2018, sec. 7.10;
    Merritt, Hydraulic Control Systems, 1967.
    Fails with a velocity of coarse resolution, whose difference is noise; with a low-pass or a valve slower
    than the axis, as PressureFeedback does; and also opposes acceleration that the demand asks for, unless an
    acceleration feedforward of k_a gives it back.
    """

    controller: Controller
    acceleration_gain: Annotated[float, Field("V s^2/m", "acceleration feedback k_a", at_least=0)]
    derivative: FilteredDerivative = FilteredDerivative()
    saturation: Saturation = Saturation()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [valve_damps(facts)]

    def init(self) -> AccelerationFeedbackState:
        return AccelerationFeedbackState(0.0, 0.0, self.derivative.init(), self.controller.init())

    def step(
        self, s: AccelerationFeedbackState, y: Measurement, r: Demand, dt: float
    ) -> AccelerationFeedbackState:
        derivative = self.derivative.step(s.derivative, y.velocity, 0.0, dt)
        fed_back = self.acceleration_gain * derivative.rate
        controller = self.controller.step(s.controller, y.with_command(y.command + s.fed_back), r, dt)
        u = self.saturation.apply(controller.u - fed_back)
        return AccelerationFeedbackState(u, fed_back, derivative, controller)
