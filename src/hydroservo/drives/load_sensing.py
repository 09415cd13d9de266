"""A pump that delivers no more pressure than the load takes."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Block, Field
from hydroservo.drives.valve_on_supply import ValveOnSupply
from hydroservo.roles import Drive, role
from hydroservo.signals import Feed, PortFlows, Pressures
from hydroservo.sources import DATASHEET

__all__ = ["LoadSensing", "LoadSensingState"]


class LoadSensingState(NamedTuple):
    """The pressure that the pump is set to, and the state of the drive that it feeds."""

    pressure: Annotated[float, Field("Pa", "pressure p of the pump")]
    drive: Block


@role(Drive)
class LoadSensing(NamedTuple):
    """The loop's supply as a load-sensing pump: its pressure follows the load's with a margin.

    The load is that of the chamber whose edge the spool opens to P, or of the tank with the spool at 0; the
    supply's pressure p_P is the most that the pump may reach::

        T dp/dt = min(p_P, max(p_load + p_margin, p_T)) - p

    The drive in it finds min(p, p_P) for its supply, and draws that times its flow, not p_P times it. The
    pump begins at its margin, as with the spool at 0 for long.

    Source: Jelali and Kroll, Hydraulic Servo-systems, 2003, ch. 2 (supplies that follow the load); the lag as
    one time constant is chosen here.
    Fails with a supply of fixed displacement, such as PumpSupply, whose relief valve takes what the valve
    does not: it draws more energy; and where the pump's control swings, which is of first order here.
    """

    margin: Annotated[float, Field("Pa", "margin p_margin above the load", DATASHEET, above=0)]
    time_constant: Annotated[float, Field("s", "time constant T of the pump's control", above=0)]
    drive: Drive = ValveOnSupply()

    def init(self) -> LoadSensingState:
        return LoadSensingState(self.margin, self.drive.init())

    def deriv(
        self, s: LoadSensingState, feed: Feed, pressure_a: float, pressure_b: float
    ) -> LoadSensingState:
        wanted = ops.maximum(self.load(feed, pressure_a, pressure_b) + self.margin, feed.line.tank)
        reached = ops.minimum(wanted, feed.line.supply)
        return LoadSensingState(
            (reached - s.pressure) * (1.0 / self.time_constant),
            self.drive.deriv(s.drive, self.delivered(s, feed), pressure_a, pressure_b),
        )

    def flows(self, s: LoadSensingState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        return self.drive.flows(s.drive, self.delivered(s, feed), pressure_a, pressure_b)

    def load_flow(self, s: LoadSensingState, feed: Feed, load_pressure: float) -> float:
        return self.drive.load_flow(s.drive, self.delivered(s, feed), load_pressure)

    def power(self, s: LoadSensingState, feed: Feed, flows: PortFlows) -> float:
        return self.drive.power(s.drive, self.delivered(s, feed), flows)

    def delivered(self, s: LoadSensingState, feed: Feed) -> Feed:
        """What the drive in front of the pump finds: the supply's line at the pump's pressure."""
        line = Pressures(ops.minimum(s.pressure, feed.line.supply), feed.line.tank)
        return Feed(feed.command, feed.edges, feed.opening, line)

    def load(self, feed: Feed, pressure_a: float, pressure_b: float) -> float:
        """The pressure that is sensed [Pa]."""
        closed = ops.where(feed.opening < 0.0, pressure_b, feed.line.tank)
        return ops.where(feed.opening > 0.0, pressure_a, closed)
