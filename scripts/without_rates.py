"""A law that is told none of its demand's derivatives, for the ablations of scripts/factorial."""

from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.block import Block
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class WithoutRatesState(NamedTuple):
    """The last command, and the state of the law."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
class WithoutRates(NamedTuple):
    """A nested law whose demand seems to stand still at each sample: r' = r'' = 0.

    Fails as a law of its own: what the demand's rates would have fed forward is left to the feedback.
    """

    controller: Controller

    def init(self) -> WithoutRatesState:
        return WithoutRatesState(0.0, self.controller.init())

    def step(self, s: WithoutRatesState, y: Measurement, r: Demand, dt: float) -> WithoutRatesState:
        controller = self.controller.step(s.controller, y, Demand(r.value, 0.0, 0.0), dt)
        return WithoutRatesState(controller.u, controller)
