"""Sensors that see the state itself."""

from typing import NamedTuple

from hydroservo.core.roles import Sensors, role
from hydroservo.core.signals import Draws, MachineOutputs, Measurement


class IdealSensorsState(NamedTuple):
    """Ideal sensors remember nothing."""


@role(Sensors)
class IdealSensors(NamedTuple):
    """Velocity, load pressure and position without noise, delay or quantisation.

    Source: Sec. 2 of doi:10.1007/s42401-021-00087-w takes both states as measured.
    Fails on every real rig: velocity comes from an encoder there, and pressure with noise; see NoisySensors.
    """

    def init(self) -> IdealSensorsState:
        return IdealSensorsState()

    def step(
        self, s: IdealSensorsState, machine: MachineOutputs, draws: Draws, dt: float
    ) -> IdealSensorsState:
        return s

    def measure(self, s: IdealSensorsState, machine: MachineOutputs, command: float) -> Measurement:
        return Measurement(
            machine.velocity,
            machine.hydraulic_force,
            machine.position,
            command,
            machine.pressure_a,
            machine.pressure_b,
            machine.force,
        )
