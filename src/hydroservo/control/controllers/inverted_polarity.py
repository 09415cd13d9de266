"""A law for a signal that falls as the command rises."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class InvertedPolarityState(NamedTuple):
    """What is put out, and the nested law's state."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
class InvertedPolarity(NamedTuple):
    """The command of a nested law with the other sign, u = -u_law.

    It is for a signal that falls as the command rises, such as the pressure in chamber B, or a valve whose
    ports are exchanged: gains stay above 0. Process control calls what this makes of a law direct acting. The
    nested law learns of the applied command with the other sign too.

    Source: the output polarity of axis controllers, such as the parameter Invert Output Polarity of Delta
    RMCs, RMCTools online help, 2012.
    Fails around a law whose signal rises with the command: it drives that away. What knows the valve's
    directions (DirectionalGain, DeadBandCompensation, FlowCompensation and the like) belongs around it,
    AntiWindup, whose gain is above 0, inside.
    """

    controller: Controller

    def init(self) -> InvertedPolarityState:
        return InvertedPolarityState(0.0, self.controller.init())

    def step(self, s: InvertedPolarityState, y: Measurement, r: Demand, dt: float) -> InvertedPolarityState:
        controller = self.controller.step(s.controller, y.with_command(-y.command), r, dt)
        return InvertedPolarityState(-controller.u, controller)
