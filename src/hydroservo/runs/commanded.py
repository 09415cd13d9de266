"""A law that is told its command from outside, and keeps what it is given."""

import math
from typing import Annotated, NamedTuple

from hydroservo.block import Field
from hydroservo.roles import Controller, role
from hydroservo.signals import Demand, Measurement

NOTHING = Measurement(*(math.nan,) * len(Measurement._fields))  # yet; a signal that nothing measures stays so


class CommandedState(NamedTuple):
    """The command, which others write, and what was measured at the last sample."""

    u: Annotated[float, Field("V", "command given from outside")] = 0.0
    measured: Measurement = NOTHING


@role(Controller)
class Commanded(NamedTuple):
    """No law: the command is what stands in its state, written there from outside between two samples.

    Source: a definition.
    Fails to act by itself: what nobody exchanges stays.
    """

    def init(self) -> CommandedState:
        return CommandedState()

    def step(self, s: CommandedState, y: Measurement, r: Demand, dt: float) -> CommandedState:
        return CommandedState(s.u, y)
