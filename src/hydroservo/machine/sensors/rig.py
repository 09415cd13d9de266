"""The sensors of a rig, put together from single ones."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.roles import (
    ForceSensor,
    PositionSensor,
    PressureSensor,
    Sensors,
    VelocityEstimator,
    role,
)
from hydroservo.core.signals import Draws, MachineOutputs, Measurement
from hydroservo.machine.sensors.difference import Difference
from hydroservo.machine.sensors.no_force import NoForce
from hydroservo.machine.sensors.no_pressure import NoPressure

AS_THE_PLANT = 0.0
SHARE = 16.0  # streams of random numbers for each sensor
REST = MachineOutputs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class RigSensorsState(NamedTuple):
    """The states of the sensors; each holds its reading as ``value``."""

    position: Block
    velocity: Block
    pressure_a: Block
    pressure_b: Block
    force: Block


@role(Sensors)
class RigSensors(NamedTuple):
    """A position sensor, a velocity from it or from a sensor of its own, pressure sensors and a load cell.

    The hydraulic force is not measured: it is area_a p_a - area_b p_b, with the areas that the controller's
    side knows; those of the plant ("auto") unless others are given. A sensor whose reading is nan measures
    nothing (NoPosition, NoPressure, NoForce), and what is computed from it is missing too.

    Source: a definition.
    Fails where sensors are read at different instants.
    """

    position: PositionSensor
    velocity: VelocityEstimator = Difference()
    pressure_a: PressureSensor = NoPressure()
    pressure_b: PressureSensor = NoPressure()
    area_a: Annotated[
        float, Field("m^2", "piston area at chamber A as known", "the plant's", above=0, auto=AS_THE_PLANT)
    ] = AS_THE_PLANT
    area_b: Annotated[
        float, Field("m^2", "piston area at chamber B as known", "the plant's", above=0, auto=AS_THE_PLANT)
    ] = AS_THE_PLANT
    force: ForceSensor = NoForce()

    def init(self) -> RigSensorsState:
        return RigSensorsState(
            self.position.init(),
            self.velocity.init(),
            self.pressure_a.init(),
            self.pressure_b.init(),
            self.force.init(),
        )

    def step(self, s: RigSensorsState, machine: MachineOutputs, draws: Draws, dt: float) -> RigSensorsState:
        position = self.position.step(s.position, machine.position, draws, dt)
        return RigSensorsState(
            position,
            self.velocity.step(s.velocity, machine, position.value, self.share(draws, 1.0), dt),
            self.pressure_a.step(s.pressure_a, machine.pressure_a, self.share(draws, 2.0), dt),
            self.pressure_b.step(s.pressure_b, machine.pressure_b, self.share(draws, 3.0), dt),
            self.force.step(s.force, machine.force, self.share(draws, 4.0), dt),
        )

    def share(self, draws: Draws, number: float) -> Draws:
        """Where one of the sensors draws its random numbers."""
        return Draws(draws.seed, draws.stream + SHARE * number, draws.sample)

    def measure(self, s: RigSensorsState, machine: MachineOutputs, command: float) -> Measurement:
        a, b = s.pressure_a.value, s.pressure_b.value
        hydraulic_force = self.area_a * a - self.area_b * b
        return Measurement(s.velocity.value, hydraulic_force, s.position.value, command, a, b, s.force.value)

    def missing(self) -> tuple[str, ...]:
        """The fields of a measurement that are not measured: those that are nan when the machine rests."""
        s = self.step(self.init(), REST, Draws(0.0, 0.0, 0.0), 1.0)
        y = self.measure(s, REST, 0.0)
        return tuple(name for name, value in zip(y._fields, y, strict=True) if value != value)  # noqa: PLR0124
