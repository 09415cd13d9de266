"""A law whose command comes a sample late."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class DelayState(NamedTuple):
    """What is put out, and the nested law's state, whose command is put out next."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
class Delay(NamedTuple):
    """The command that a nested law gave at the sample before: u_k = u_law,(k-1), and 0 at the first.

    Nested in itself, it delays by more; a delay of part of a sample period is a DelayedHold.

    Source: Astrom and Wittenmark, Computer-Controlled Systems, 1997, sec. 9.3.
    Fails where the delay changes from sample to sample.
    """

    controller: Controller

    def init(self) -> DelayState:
        return DelayState(0.0, self.controller.init())

    def step(self, s: DelayState, y: Measurement, r: Demand, dt: float) -> DelayState:
        return DelayState(s.controller.u, self.controller.step(s.controller, y, r, dt))
