"""A position sensor that counts."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import PositionSensor, role
from hydroservo.core.signals import Draws
from hydroservo.machine.sensors.ideal_position import PositionReading

FINE = 1e-15  # [m] a resolution that nothing tells from none


@role(PositionSensor)
class Encoder(NamedTuple):
    """Position in whole counts of an incremental or absolute scale, the nearest one.

    y_m = q nearest(y/q)

    The error lies within +-q/2, the scale's zero being in the middle of a count; in motion that meets all
    parts of a count alike it has mean 0 and rms q/sqrt(12).

    Source: Widrow and Kollar, Quantization Noise, 2008, ch. 1.
    Fails at rest and at low speed, where the error is no noise: it is constant, or a sawtooth.
    """

    resolution: Annotated[float, Field("m", "length q of a count", above=0)]

    def smoothed(self) -> "Encoder":
        return self._replace(resolution=FINE)

    def init(self) -> PositionReading:
        return PositionReading(0.0)

    def step(self, s: PositionReading, position: float, draws: Draws, dt: float) -> PositionReading:
        return PositionReading(self.resolution * ops.nearest(position / self.resolution))
