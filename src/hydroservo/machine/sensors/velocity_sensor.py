"""A sensor of the velocity itself."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import VelocityEstimator, role
from hydroservo.core.signals import Draws, MachineOutputs


class VelocityReading(NamedTuple):
    """What a velocity sensor reads."""

    value: Annotated[float, Field("m/s", "measured piston velocity")]


@role(VelocityEstimator)
class VelocitySensor(NamedTuple):
    """A tachometer: the machine's velocity with additive Gaussian noise, new at each sample.

    Source: chosen here; white noise is the usual first model of a sensor.
    Fails where noise is coloured, as behind a filter, or has ripple that turns with the shaft.
    """

    noise: Annotated[float, Field("m/s", "rms of the noise", "0: ideal", at_least=0)] = 0.0

    def init(self) -> VelocityReading:
        return VelocityReading(0.0)

    def step(
        self, s: VelocityReading, machine: MachineOutputs, position: float, draws: Draws, dt: float
    ) -> VelocityReading:
        noise = self.noise * ops.normal(draws.seed, draws.stream, draws.sample)
        return VelocityReading(machine.velocity + noise)
