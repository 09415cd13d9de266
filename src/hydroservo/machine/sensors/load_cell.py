"""A load cell at the rod's end."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import ForceSensor, role
from hydroservo.core.signals import Draws
from hydroservo.machine.sensors.no_force import ForceReading


@role(ForceSensor)
class LoadCell(NamedTuple):
    """The force at the rod with additive Gaussian noise: value = F + noise n_k, n_k of deviation 1.

    Source: the entries of any load cell's data sheet; white noise is the usual first model of an amplifier's.
    Fails where the cell's own mass and spring swing, and where the specimen's inertia lies behind it.
    """

    noise: Annotated[float, Field("N", "rms of the noise", at_least=0)]

    def init(self) -> ForceReading:
        return ForceReading(0.0)

    def step(self, s: ForceReading, force: float, draws: Draws, dt: float) -> ForceReading:
        return ForceReading(force + self.noise * ops.normal(draws.seed, draws.stream, draws.sample))
