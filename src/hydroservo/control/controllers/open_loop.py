"""No control: the demand is the command."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.command import Command
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.block import Field
from hydroservo.core.roles import Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement


class OpenLoopState(NamedTuple):
    """The last command."""

    u: Annotated[float, Field("V", "command")]


@role(Controller)
@controlling(Command)
class OpenLoop(NamedTuple):
    """u = sat(r): the demand is the command, in a loop whose ``controls`` is Command.

    Source: a definition; the excitation of identification and frequency response.
    Fails to keep the machine anywhere: it drifts, to the end of its stroke in time.
    """

    saturation: Saturation = Saturation()

    def init(self) -> OpenLoopState:
        return OpenLoopState(0.0)

    def step(self, s: OpenLoopState, y: Measurement, r: Demand, dt: float) -> OpenLoopState:
        return OpenLoopState(self.saturation.apply(r.value))
