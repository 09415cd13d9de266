"""The loop's valve on its supply."""

from typing import NamedTuple

from hydroservo.core.roles import Drive, MeteringEdges, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.machine.drives.ports import Ports


class ValveOnSupplyState(NamedTuple):
    """It remembers nothing: the valve and the supply have states of their own."""


@role(Drive)
class ValveOnSupply(NamedTuple):
    """The loop's valve meters the oil between its supply and the cylinder's ports, with nothing between.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6 (the valve-piston combination).
    Fails where lines between valve and cylinder hold oil that counts or resist its flow.
    """

    def init(self) -> ValveOnSupplyState:
        return ValveOnSupplyState()

    def deriv(
        self, s: ValveOnSupplyState, feed: Feed, pressure_a: float, pressure_b: float
    ) -> ValveOnSupplyState:
        return s

    def flows(self, s: ValveOnSupplyState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        edges: MeteringEdges = feed.edges
        return edges.port_flows(feed.opening, feed.line, pressure_a, pressure_b)

    def load_flow(self, s: ValveOnSupplyState, feed: Feed, load_pressure: float) -> float:
        edges: MeteringEdges = feed.edges
        return edges.flow(feed.opening, feed.line.supply - feed.line.tank, load_pressure)

    def power(
        self, s: ValveOnSupplyState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        return feed.line.supply * flows.supply


def open_ports(edges: MeteringEdges, opening: float, line: Pressures) -> Ports:
    """The ports of a valve that stands open, outside any loop.

    Args:
        edges: its metering edges.
        opening: of its spool [m].
        line: the pressures at its ports P and T.
    """
    return Ports(ValveOnSupply(), ValveOnSupplyState(), Feed(0.0, edges, opening, line))
