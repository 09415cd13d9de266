"""A drive in a file of its own: copy it, change what lies between valve and cylinder, run it.

In Python: ``replace(loop, {"drive": Bypass(conductance=5e-12)})``.
From a scenario: ``hydroservo run my_drive.toml --plugin my_drive.py``.
"""

from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.block import Block
from hydroservo.core.roles import Drive, role
from hydroservo.core.signals import Feed, PortFlows
from hydroservo.machine.drives import ValveOnSupply


@role(Drive)
class Bypass(NamedTuple):
    """A throttle from port to port, behind a valve or any other drive: it damps, and costs energy.

    G (p_A - p_B) flows past the cylinder, from port A to port B.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6 (a leak past the piston damps the load).
    Fails where the flow through the throttle is turbulent.
    """

    conductance: Annotated[float, Field("m^3/(s Pa)", "flow G per pressure", "example", at_least=0)] = 2e-11
    drive: Drive = ValveOnSupply()

    def init(self) -> Block:
        return self.drive.init()

    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block:
        return self.drive.deriv(s, feed, pressure_a, pressure_b)

    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        passed = self.drive.flows(s, feed, pressure_a, pressure_b)
        past = self.conductance * (pressure_a - pressure_b)
        return PortFlows(passed.a - past, passed.b - past, supply=passed.supply, tank=passed.tank)

    def load_flow(self, s: Block, feed: Feed, load_pressure: float) -> float:
        return self.drive.load_flow(s, feed, load_pressure) - self.conductance * load_pressure

    def power(self, s: Block, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float) -> float:
        passed = self.drive.flows(s, feed, pressure_a, pressure_b)
        return self.drive.power(s, feed, passed, pressure_a, pressure_b)
