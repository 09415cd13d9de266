"""Sensors whose readings get lost now and then."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Sensors, role
from hydroservo.core.signals import Draws, MachineOutputs, Measurement
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.sensors.ideal import IdealSensors
from hydroservo.machine.sensors.missing import missing_signals

OWN = 2.0  # streams: one is drawn from, and the nested sensors' first must be even


class DropoutState(NamedTuple):
    """The nested sensors' state, and what was last received of them."""

    sensors: Block
    received: MachineOutputs


@role(Sensors)
class Dropout(NamedTuple):
    """Readings of nested sensors of which each sample's is lost with a probability: the last one is kept.

    y_k = y_(k-1) where U_k < probability, else y'_k, with U_k drawn evenly from [0, 1); y_0 = y'_0

    Losses are independent of each other, and a sample is lost as a whole. The command is no reading.

    Source: a definition; Gilbert, Bell System Technical Journal 39(5), 1960, has losses that come in bursts.
    Fails for a velocity that the receiver computes: here it is lost and kept like the others.
    """

    probability: Annotated[
        float, Field("", "probability that a sample is lost", CHOSEN, at_least=0, at_most=1)
    ] = 0.01
    sensors: Sensors = IdealSensors()

    def init(self) -> DropoutState:
        nothing = MachineOutputs(math.nan, math.nan, math.nan, math.nan, math.nan, math.nan)
        return DropoutState(self.sensors.init(), nothing)

    def step(self, s: DropoutState, machine: MachineOutputs, draws: Draws, dt: float) -> DropoutState:
        lost = ops.uniform(draws.seed, draws.stream, draws.sample) < self.probability
        inner = Draws(draws.seed, draws.stream + OWN, draws.sample)
        sensors = self.sensors.step(s.sensors, machine, inner, dt)
        y, last = self.sensors.measure(sensors, machine, 0.0), s.received
        received = MachineOutputs(
            self.kept(lost, last.velocity, y.velocity),
            self.kept(lost, last.hydraulic_force, y.hydraulic_force),
            self.kept(lost, last.position, y.position),
            self.kept(lost, last.pressure_a, y.pressure_a),
            self.kept(lost, last.pressure_b, y.pressure_b),
            self.kept(lost, last.force, y.force),
        )
        return DropoutState(sensors, received)

    def kept(self, lost: bool, before: float, now: float) -> float:
        """The reading before if this one is lost; at the first sample there is none."""
        return ops.where(lost, ops.where(ops.isnan(before), now, before), now)

    def measure(self, s: DropoutState, machine: MachineOutputs, command: float) -> Measurement:
        y = s.received
        return Measurement(
            y.velocity, y.hydraulic_force, y.position, command, y.pressure_a, y.pressure_b, y.force
        )

    def missing(self) -> tuple[str, ...]:
        """The fields of a measurement that the nested sensors do not measure."""
        return missing_signals(self.sensors)
