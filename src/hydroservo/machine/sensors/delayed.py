"""Sensors whose readings come a sample late."""

import math
from typing import NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.roles import Sensors, role
from hydroservo.core.signals import Draws, MachineOutputs, Measurement
from hydroservo.machine.sensors.ideal import IdealSensors
from hydroservo.machine.sensors.missing import missing_signals


class DelayedSensorsState(NamedTuple):
    """The nested sensors' state, what they read at this sample, and what is passed on: the reading before."""

    sensors: Block
    latest: MachineOutputs
    passed: MachineOutputs


@role(Sensors)
class DelayedSensors(NamedTuple):
    """Readings of nested sensors, one sample period late: y_k = y'_(k-1), and y_0 = y'_0.

    The command is no reading: a computer knows what it has put out. Nested in itself, it delays by more.

    Source: a definition.
    Fails where the delay is no whole number of sample periods.
    """

    sensors: Sensors = IdealSensors()

    def init(self) -> DelayedSensorsState:
        nothing = MachineOutputs(math.nan, math.nan, math.nan, math.nan, math.nan, math.nan)
        return DelayedSensorsState(self.sensors.init(), nothing, nothing)

    def step(
        self, s: DelayedSensorsState, machine: MachineOutputs, draws: Draws, dt: float
    ) -> DelayedSensorsState:
        sensors = self.sensors.step(s.sensors, machine, draws, dt)
        y = self.sensors.measure(sensors, machine, 0.0)
        passed = MachineOutputs(
            self.known(s.latest.velocity, y.velocity),
            self.known(s.latest.hydraulic_force, y.hydraulic_force),
            self.known(s.latest.position, y.position),
            self.known(s.latest.pressure_a, y.pressure_a),
            self.known(s.latest.pressure_b, y.pressure_b),
            self.known(s.latest.force, y.force),
        )
        latest = MachineOutputs(
            y.velocity, y.hydraulic_force, y.position, y.pressure_a, y.pressure_b, y.force
        )
        return DelayedSensorsState(sensors, latest, passed)

    def known(self, before: float, now: float) -> float:
        """The reading before; at the first sample there is none."""
        return ops.where(ops.isnan(before), now, before)

    def measure(self, s: DelayedSensorsState, machine: MachineOutputs, command: float) -> Measurement:
        y = s.passed
        return Measurement(
            y.velocity, y.hydraulic_force, y.position, command, y.pressure_a, y.pressure_b, y.force
        )

    def missing(self) -> tuple[str, ...]:
        """The fields of a measurement that the nested sensors do not measure."""
        return missing_signals(self.sensors)
