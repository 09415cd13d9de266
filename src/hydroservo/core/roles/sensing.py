"""What a controller sees of the machine."""

from typing import Protocol

from hydroservo.core.roles.blocks import Block
from hydroservo.core.signals import Draws, MachineOutputs, Measurement


class Sensors(Protocol):
    """What the controller sees of the machine: a sampled state (noise, filters), and the measurement from it.

    ``step`` comes first at a sample; ``measure`` then sees its new state. Sensors that leave fields of the
    measurement unmeasured, as nan, have a method ``missing()`` that names them. Those with fields ``area_a``
    and ``area_b`` [m^2] are given the plant's; those that wrap others have them as their field ``sensors``.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, machine: MachineOutputs, draws: Draws, dt: float) -> Block: ...
    def measure(self, s: Block, machine: MachineOutputs, command: float) -> Measurement: ...


class PositionSensor(Protocol):
    """A sensor of the piston's position [m]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, position: float, draws: Draws, dt: float) -> Block: ...


class VelocityEstimator(Protocol):
    """The piston's velocity [m/s]; its state holds it as ``value``.

    It is estimated from the ``position`` as measured, or measured at the machine itself.
    """

    def init(self) -> Block: ...
    def step(self, s: Block, machine: MachineOutputs, position: float, draws: Draws, dt: float) -> Block: ...


class PressureSensor(Protocol):
    """A sensor of a chamber's pressure [Pa]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, pressure: float, draws: Draws, dt: float) -> Block: ...


class ForceSensor(Protocol):
    """A sensor of the force at the rod [N]; its state holds the reading ``value``, nan if it has none."""

    def init(self) -> Block: ...
    def step(self, s: Block, force: float, draws: Draws, dt: float) -> Block: ...
