"""A loop around a velocity loop."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.this_signal import THIS_SIGNAL
from hydroservo.control.controlled.velocity import Velocity
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, Controller, role
from hydroservo.core.signals import Demand, Measurement


class CascadeState(NamedTuple):
    """What is put out, what the velocity is to be, and the state of the velocity's law."""

    u: Annotated[float, Field("V", "command")]
    velocity_demand: Annotated[float, Field("m/s", "demand of the nested law")]
    controller: Block


@role(Controller)
class Cascade(NamedTuple):
    """A P law of the controlled signal that asks a nested law for a velocity: position over velocity.

    v_d = clip(k_p (r - y) + k_v r', -max_velocity, max_velocity)

    The nested law controls the velocity, whatever the loop controls, and is given v_d with the rate k_v r''
    (0 where v_d is limited) and the second rate 0: what the demand asks for of the feedforward, without the
    share of the error. In a position loop k_v is 1 for a velocity that is demanded in full; in a force
    loop it is the compliance of what is pressed [m/N].

    Source: cascade control: Astrom and Hagglund, Advanced PID Control, 2006.
    Fails where the velocity loop is not several times faster than the loop around it, and with a velocity
    that is the difference of a coarse position. The integral of a nested PI winds up while an end stop holds.
    """

    controller: Controller
    proportional_gain: Annotated[float, Field("m/(s y)", "velocity per error k_p", at_least=0)]
    max_velocity: Annotated[float, Field("m/s", "largest velocity demand", above=0)]
    rate_feedforward: Annotated[float, Field("m/y", "velocity per rate of the demand k_v", "0: none")] = 0.0
    inner_controls: Velocity = Velocity()
    controls: ControlledSignal = THIS_SIGNAL

    def init(self) -> CascadeState:
        return CascadeState(0.0, 0.0, self.controller.init())

    def step(self, s: CascadeState, y: Measurement, r: Demand, dt: float) -> CascadeState:
        error = r.value - self.controls.of(y, y.command)
        wanted = self.proportional_gain * error + self.rate_feedforward * r.rate
        velocity = ops.clip(wanted, -self.max_velocity, self.max_velocity)
        rate = ops.where(velocity == wanted, self.rate_feedforward * r.second_rate, 0.0)
        controller = self.controller.step(s.controller, y, Demand(velocity, rate, 0.0), dt)
        return CascadeState(controller.u, velocity, controller)
