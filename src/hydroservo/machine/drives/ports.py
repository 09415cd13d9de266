"""A drive as the cylinder sees it."""

from typing import NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.signals import Feed, PortFlows


class Ports(NamedTuple):
    """The two ports of a drive at one instant: what flows through them at given pressures.

    Attributes:
        drive: the drive.
        state: its state.
        feed: what the valve and the supply hold ready.
    """

    drive: Block
    state: Block
    feed: Feed

    def flows(self, pressure_a: float, pressure_b: float) -> PortFlows:
        """The flows at the pressures in the two chambers [Pa]."""
        flows: PortFlows = self.drive.flows(self.state, self.feed, pressure_a, pressure_b)
        return flows

    def load_flow(self, load_pressure: float) -> float:
        """The flow [m^3/s] to a symmetric cylinder at a load pressure [Pa], of a drive that has one."""
        flow: float = self.drive.load_flow(self.state, self.feed, load_pressure)
        return flow

    def power(self, flows: PortFlows, pressure_a: float, pressure_b: float) -> float:
        """What the drive draws while it passes these flows at the pressures in the two chambers [W]."""
        power: float = self.drive.power(self.state, self.feed, flows, pressure_a, pressure_b)
        return power
