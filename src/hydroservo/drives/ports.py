"""A drive as the cylinder sees it."""

from typing import NamedTuple

from hydroservo.block import Block
from hydroservo.roles import Drive
from hydroservo.signals import Feed, PortFlows

__all__ = ["Ports"]


class Ports(NamedTuple):
    """The two ports of a drive at one instant: what flows through them at given pressures.

    Attributes:
        drive: the drive.
        state: its state.
        feed: what the valve and the supply hold ready.
    """

    drive: Drive
    state: Block
    feed: Feed

    def flows(self, pressure_a: float, pressure_b: float) -> PortFlows:
        """The flows at the pressures in the two chambers [Pa]."""
        return self.drive.flows(self.state, self.feed, pressure_a, pressure_b)

    def load_flow(self, load_pressure: float) -> float:
        """The flow [m^3/s] to a symmetric cylinder at a load pressure [Pa]."""
        return self.drive.load_flow(self.state, self.feed, load_pressure)

    def power(self, flows: PortFlows) -> float:
        """What the drive draws while it passes these flows [W]."""
        return self.drive.power(self.state, self.feed, flows)
