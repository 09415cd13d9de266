"""A position sensor without error."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import PositionSensor, role
from hydroservo.core.signals import Draws


class PositionReading(NamedTuple):
    """What a position sensor reads."""

    value: Annotated[float, Field("m", "measured piston position")]


@role(PositionSensor)
class IdealPosition(NamedTuple):
    """The position itself.

    Source: a definition.
    Fails on every real rig, whose sensors have a resolution; see Encoder.
    """

    def init(self) -> PositionReading:
        return PositionReading(0.0)

    def step(self, s: PositionReading, position: float, draws: Draws, dt: float) -> PositionReading:
        return PositionReading(position)
