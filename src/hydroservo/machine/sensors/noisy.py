"""Sensors with white noise."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Sensors, role
from hydroservo.core.signals import Draws, MachineOutputs, Measurement


class NoisySensorsState(NamedTuple):
    """What is measured at this sample."""

    velocity: Annotated[float, Field("m/s", "measured piston velocity")]
    hydraulic_force: Annotated[float, Field("N", "measured load-pressure force")]


@role(Sensors)
class NoisySensors(NamedTuple):
    """Velocity and load pressure with additive Gaussian noise, new at each sample; position without.

    y_k = x_k + noise n_k, n_k normal with mean 0 and standard deviation 1, independent of all others

    Source: chosen here; white noise is the usual first model of a sensor.
    Fails where noise is coloured, as after a filter, or depends on the signal, as quantisation does. Its
    power spreads up to half the sampling rate, so a shorter sample period with the same rms is less
    noise in the loop's bandwidth; keep rms^2 period constant to compare periods under the same noise.
    """

    velocity_noise: Annotated[float, Field("m/s", "rms of the velocity's noise", at_least=0)]
    hydraulic_force_noise: Annotated[float, Field("N", "rms of the hydraulic force's noise", at_least=0)]

    def init(self) -> NoisySensorsState:
        return NoisySensorsState(0.0, 0.0)

    def step(
        self, s: NoisySensorsState, machine: MachineOutputs, draws: Draws, dt: float
    ) -> NoisySensorsState:
        first = ops.normal(draws.seed, draws.stream, draws.sample)
        second = ops.normal(draws.seed, draws.stream + 1.0, draws.sample)
        return NoisySensorsState(
            machine.velocity + self.velocity_noise * first,
            machine.hydraulic_force + self.hydraulic_force_noise * second,
        )

    def measure(self, s: NoisySensorsState, machine: MachineOutputs, command: float) -> Measurement:
        return Measurement(
            s.velocity,
            s.hydraulic_force,
            machine.position,
            command,
            machine.pressure_a,
            machine.pressure_b,
            machine.force,
        )
