"""No load cell."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import ForceSensor, role
from hydroservo.core.signals import Draws


class ForceReading(NamedTuple):
    """What a load cell reads."""

    value: Annotated[float, Field("N", "measured force")]


@role(ForceSensor)
class NoForce(NamedTuple):
    """The force at the rod is not measured: its reading is nan, and a law that uses it is refused.

    Source: a definition.
    Fails never.
    """

    def init(self) -> ForceReading:
        return ForceReading(math.nan)

    def step(self, s: ForceReading, force: float, draws: Draws, dt: float) -> ForceReading:
        return ForceReading(math.nan)
