"""A law that holds a signal of its own at a fixed value."""

from typing import Annotated, NamedTuple

from hydroservo.control.controlled.force import Force
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import ControlledSignal, Controller, controlling, role
from hydroservo.core.signals import Demand, Measurement


class FixedDemandState(NamedTuple):
    """The command, and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
@controlling()
class FixedDemand(NamedTuple):
    """A nested law that holds a signal at a value, whatever the loop around it controls and demands.

    Source: a definition.
    Fails where the law in it does.
    """

    controller: Controller
    value: Annotated[float, Field("y", "{y} that is held")]
    controls: ControlledSignal = Force()

    def init(self) -> FixedDemandState:
        return FixedDemandState(0.0, self.controller.init())

    def step(self, s: FixedDemandState, y: Measurement, r: Demand, dt: float) -> FixedDemandState:
        controller = self.controller.step(s.controller, y, Demand(self.value, 0.0, 0.0), dt)
        return FixedDemandState(controller.u, controller)
