"""Relief and anti-cavitation valves at the two ports."""

from typing import NamedTuple

from hydroservo.core.block import Block
from hydroservo.core.roles import CheckFlow, Drive, Relief, role
from hydroservo.core.signals import Feed, PortFlows
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply


@role(Drive)
class PortValves(NamedTuple):
    """A relief and a check valve at each port of another drive, to and from the tank's line.

    With the flows Q_DA and Q_DB of the drive, and p_T in the tank's line::

        Q_A = Q_DA + check(p_T - p_A) - relief(p_A - p_T)
        Q_B = Q_DB - check(p_T - p_B) + relief(p_B - p_T)

    Q_A flows into chamber A, Q_B out of chamber B. The relief valves bound the pressure at a port that is
    shut, as a load that runs on or an area ratio raises it; the check valves keep oil behind a load that runs
    ahead. With Hoses or Lines as their drive they stand at the cylinder; as the drive of Hoses or Lines, at
    the control valve.

    Source: Merritt, Hydraulic Control Systems, 1967 (pressure control valves in steady state).
    Fails where their springs and masses chatter; and with a plant that is described by its load pressure,
    which is refused: it has no chambers.
    """

    relief: Relief
    check_valve: CheckFlow
    drive: Drive = ValveOnSupply()

    def init(self) -> Block:
        return self.drive.init()

    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block:
        return self.drive.deriv(s, feed, pressure_a, pressure_b)

    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        fed = self.drive.flows(s, feed, pressure_a, pressure_b)
        relieved_a, relieved_b = self.relieved_flow(feed, pressure_a), self.relieved_flow(feed, pressure_b)
        tank = fed.tank + relieved_a + relieved_b
        return PortFlows(fed.a - relieved_a, fed.b + relieved_b, supply=fed.supply, tank=tank)

    def power(self, s: Block, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float) -> float:
        own = self.drive.flows(s, feed, pressure_a, pressure_b)
        return self.drive.power(s, feed, own, pressure_a, pressure_b)

    def relieved_flow(self, feed: Feed, pressure: float) -> float:
        """The flow from a port to the tank's line, less the flow back [m^3/s]."""
        above = pressure - feed.line.tank
        return self.relief.flow(above) - self.check_valve.flow(-above)
