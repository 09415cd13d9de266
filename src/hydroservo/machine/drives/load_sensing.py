"""A pump that delivers no more pressure than the load takes."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.hooks import at_ports, is_valveless
from hydroservo.core.roles import Drive, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.core.sources import DATASHEET
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply


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

    The drive in it finds min(p, p_P) for its supply, and draws that times its flow, not p_P times it. A start
    pressure that is left open ("auto") is that of standby, with the spool at 0 for long: p_T + p_margin.

    Source: Jelali and Kroll, Hydraulic Servo-systems, 2003, ch. 2 (supplies that follow the load); the lag as
    one time constant is chosen here.
    Fails with a supply of fixed displacement, such as PumpSupply, whose relief valve takes what the valve
    does not: it draws more energy; where the pump's control swings, which is of first order here; and with a
    plant that is described by its load pressure, which is refused: it has no chambers to sense.
    """

    margin: Annotated[float, Field("Pa", "margin p_margin above the load", DATASHEET, above=0)]
    time_constant: Annotated[float, Field("s", "time constant T of the pump's control", above=0)]
    drive: Drive = ValveOnSupply()
    start_pressure: Annotated[
        float, Field("Pa", "pressure of the pump at the start", "standby", above=-ATMOSPHERE, auto=OPEN)
    ] = OPEN

    def check(self) -> None:
        if is_valveless(self.drive):
            problem = "stands in the valve's place, and a load-sensing pump feeds a valve"
            raise ParameterError("drive", type(self.drive).__name__, problem)

    def at_rest(self, line: Pressures, pressure_a: float, pressure_b: float) -> "LoadSensing":
        """The pump with the start pressure that was left open: that of standby."""
        standby = min(line.tank + self.margin, line.supply)
        start = standby if self.start_pressure == OPEN else self.start_pressure
        delivered = Pressures(min(start, line.supply), line.tank)
        inner = at_ports(self.drive, delivered, pressure_a, pressure_b)
        return self._replace(start_pressure=start, drive=inner)

    def init(self) -> LoadSensingState:
        return LoadSensingState(self.start_pressure, self.drive.init())

    def deriv(
        self, s: LoadSensingState, feed: Feed, pressure_a: float, pressure_b: float
    ) -> LoadSensingState:
        wanted = ops.maximum(feed.sensed(pressure_a, pressure_b) + self.margin, feed.line.tank)
        reached = ops.minimum(wanted, feed.line.supply)
        return LoadSensingState(
            (reached - s.pressure) * (1.0 / self.time_constant),
            self.drive.deriv(s.drive, self.delivered(s, feed), pressure_a, pressure_b),
        )

    def flows(self, s: LoadSensingState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        return self.drive.flows(s.drive, self.delivered(s, feed), pressure_a, pressure_b)

    def power(
        self, s: LoadSensingState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        return self.drive.power(s.drive, self.delivered(s, feed), flows, pressure_a, pressure_b)

    def delivered(self, s: LoadSensingState, feed: Feed) -> Feed:
        """What the drive in front of the pump finds: the supply's line at the pump's pressure."""
        return feed.with_supply(ops.minimum(s.pressure, feed.line.supply))
