"""A law that listens while its machine is driven by a tone in place of its command."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Block, Field
from hydroservo.roles import Controller, role
from hydroservo.signals import Demand, Measurement


class OpenedState(NamedTuple):
    """What the machine is given, the instant of the next sample, and the state of the law."""

    u: Annotated[float, Field("V", "command given to the machine")]
    time: Annotated[float, Field("s", "instant of the next sample")]
    controller: Block


@role(Controller)
class Opened(NamedTuple):
    """A loop opened at its command: the machine is given a tone, and what the law asks for goes nowhere.

    u = bias + A min(t/rise, 1) cos(w t)

    The law measures the machine so driven and is told this u as the command applied.

    Source: the definition of a describing function.
    Fails to keep the machine anywhere: what the tone leaves of an offset adds up in a law's integrator.
    """

    controller: Controller
    bias: Annotated[float, Field("V", "mean command")] = 0.0
    amplitude: Annotated[float, Field("V", "amplitude A of the tone", at_least=0)] = 0.0
    frequency: Annotated[float, Field("rad/s", "frequency w of the tone", at_least=0)] = 0.0
    rise: Annotated[float, Field("s", "time in which the tone grows to its amplitude", above=0)] = 0.1

    def init(self) -> OpenedState:
        return OpenedState(0.0, 0.0, self.controller.init())

    def step(self, s: OpenedState, y: Measurement, r: Demand, dt: float) -> OpenedState:
        tone = self.amplitude * ops.minimum(s.time / self.rise, 1.0) * ops.cos(self.frequency * s.time)
        return OpenedState(self.bias + tone, s.time + dt, self.controller.step(s.controller, y, r, dt))
