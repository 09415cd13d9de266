"""A law and a hold whose command comes and goes in mA or in per cent, while they count in volts."""

from typing import Annotated, Any, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, Hold
from hydroservo.core.signals import Demand, Measurement
from hydroservo.core.sources import CHOSEN

PER_VOLT = Field("1/V", "size of a volt in the unit of the command", CHOSEN, above=0)


class ConvertedState(NamedTuple):
    """The command as it goes out, and the law's state, in volts."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


class ConvertedController(NamedTuple):
    """A law that counts in volts, between a command that comes and goes in another unit: u = k u_law.

    Source: a definition.
    Fails to convert what a law holds, such as its limit: its parameters and its state stay in volts.
    """

    controller: Controller
    per_volt: Annotated[float, PER_VOLT]

    def init(self) -> ConvertedState:
        law = self.controller.init()
        return ConvertedState(self.per_volt * law.u, law)

    def step(self, s: ConvertedState, y: Measurement, r: Demand, dt: float) -> ConvertedState:
        law = self.controller.step(s.controller, y.with_command(y.command / self.per_volt), r, dt)
        return ConvertedState(self.per_volt * law.u, law)


class ConvertedHold(NamedTuple):
    """A hold of a command in another unit than the machine's volts: u_valve = u/k.

    Source: a definition.
    Fails for a hold that is not linear in the command.
    """

    hold: Hold
    per_volt: Annotated[float, PER_VOLT]

    def init(self) -> Block:
        return self.hold.init()

    def step(self, s: Block, u: float, t: float) -> Block:
        return self.hold.step(s, u, t)

    def held(self, s: Block, u: float) -> Any:
        return self.hold.held(s, u)

    def at(self, held: Any, t: float) -> float:
        return self.hold.at(held, t) / self.per_volt

    def next_jump(self, held: Any, t: float) -> float:
        return self.hold.next_jump(held, t)

    def applied(self, s: Block, u: float, dt: float) -> float:
        return self.hold.applied(s, u, dt)
