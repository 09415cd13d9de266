"""Another gain for each direction around any law."""

from typing import Annotated, NamedTuple

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class DirectionalGainState(NamedTuple):
    """What is put out, and the gain that it was given."""

    u: Annotated[float, Field("V", "command")]
    gain: Annotated[float, Field("", "command over that of the law")]
    controller: Block


@role(Controller)
class DirectionalGain(NamedTuple):
    """The command of a nested law, times a gain for each direction.

    u = sat(k_extend u_law) where u_law > 0, sat(k_retract u_law) elsewhere

    A single-rod cylinder of areas A_A and A_B on a valve with matched edges, without load, retracts slower
    than it extends, by the factor sqrt(alpha) with alpha = A_B/A_A; gains of 1 and 1/sqrt(alpha) make both
    speeds one. The nested law learns of the applied command as its own.

    Source: Moog ACV with CANopen bus interface, user manual B99224-DV018-D-211, Rev. A, 2018, sec. 7.2.6.
    Fails where the load takes much of the supply's pressure, by the root of what it leaves: see
    FlowCompensation.
    """

    controller: Controller
    extend_gain: Annotated[float, Field("", "gain where the position is to grow", "neutral", above=0)] = 1.0
    retract_gain: Annotated[float, Field("", "gain where it is to shrink", "neutral", above=0)] = 1.0
    saturation: Saturation = Saturation()

    def init(self) -> DirectionalGainState:
        return DirectionalGainState(0.0, 1.0, self.controller.init())

    def step(self, s: DirectionalGainState, y: Measurement, r: Demand, dt: float) -> DirectionalGainState:
        controller = self.controller.step(s.controller, y.with_command(y.command / s.gain), r, dt)
        gain = ops.where(controller.u > 0.0, self.extend_gain, self.retract_gain)
        return DirectionalGainState(self.saturation.apply(gain * controller.u), gain, controller)
