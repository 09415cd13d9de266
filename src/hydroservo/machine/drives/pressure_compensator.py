"""A compensator that keeps the drop over the metering edge."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.hooks import is_valveless
from hydroservo.core.roles import Drive, role
from hydroservo.core.signals import Feed, PortFlows
from hydroservo.core.sources import DATASHEET
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply


@role(Drive)
class PressureCompensator(NamedTuple):
    """A compensator before the valve: what is metered depends on the spool alone, not on the load.

    It throttles the supply's line to a spring's pressure above the load, which is that of the chamber whose
    edge the spool opens to P, or of the tank with the spool at 0::

        p = min(p_P, max(p_load + p_spring, p_T))

    and the drive in it finds p for its supply. So Q = C_d w x sqrt(2 p_spring/rho) through an edge that is
    open by x, as long as p_P is that much above the load. All oil is drawn at p_P.

    Source: Merritt, Hydraulic Control Systems, 1967 (flow control valves), in steady state.
    Fails above the compensator's own corner frequency, some tens of hertz; with edges that overlap, for it
    senses the load from the spool's first move on; under a load that runs away, which the outlet meters; and
    with a plant that is described by its load pressure, which is refused: it has no chambers to sense.
    """

    spring_pressure: Annotated[float, Field("Pa", "pressure p_spring of the spring", DATASHEET, above=0)]
    drive: Drive = ValveOnSupply()

    def check(self) -> None:
        if is_valveless(self.drive):
            problem = "stands in the valve's place, and a compensator is for the edges of a valve"
            raise ParameterError("drive", type(self.drive).__name__, problem)

    def init(self) -> Block:
        return self.drive.init()

    def deriv(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> Block:
        return self.drive.deriv(s, self.compensated(feed, pressure_a, pressure_b), pressure_a, pressure_b)

    def flows(self, s: Block, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        return self.drive.flows(s, self.compensated(feed, pressure_a, pressure_b), pressure_a, pressure_b)

    def power(self, s: Block, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float) -> float:
        return self.drive.power(s, feed, flows, pressure_a, pressure_b)

    def compensated(self, feed: Feed, pressure_a: float, pressure_b: float) -> Feed:
        """What the drive in it finds: the supply's line at the compensated pressure."""
        kept = ops.maximum(feed.sensed(pressure_a, pressure_b) + self.spring_pressure, feed.line.tank)
        return feed.with_supply(ops.minimum(kept, feed.line.supply))
