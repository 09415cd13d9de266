"""A counterbalance valve at the cylinder."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.hooks import at_ports
from hydroservo.core.roles import CheckFlow, Drive, Oil, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.core.sources import CHOSEN, DATASHEET
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply


class CounterbalanceState(NamedTuple):
    """The pressure between the valve and the drive behind it, and that drive's state."""

    pressure: Annotated[float, Field("Pa", "pressure p_V in the line behind the valve")]
    drive: Block


@role(Drive)
class Counterbalance(NamedTuple):
    """A counterbalance (overcentre) valve in the line to chamber A, or to B, with another drive behind it.

    With the pressure p of its chamber, p_X of the other chamber, which pilots it, and p_V in the volume V
    behind it, its relief stage opens by x, and a check valve passes what flows towards the chamber::

        z = p - p_V + R (p_X - p_V) - p_c           x = z/h within 0 and 1
        Q = check(p_V - p) - Q_n x root(p - p_V)/root(p_n)
        dp_V/dt = beta_e(p_V)/V (Q_drive - Q)

    with root(d) = d/(d^2 + d_t^2)^(1/4). Q flows into the chamber. Without a pilot it opens at
    p = p_c + (1 + R) p_V: a pressure behind the valve raises its setting. Two of them, one in each line,
    are one around the other.

    Source: the balance of forces on a poppet with the areas 1, R and 1 + R; Merritt, Hydraulic Control
    Systems, 1967 (orifices, pressure control valves). The two transitions are chosen here.
    Fails where the poppet's mass and friction matter: its hysteresis is several per cent of the setting; and
    with a plant that is described by its load pressure, which is refused: it throttles one side alone.
    """

    pilot_ratio: Annotated[float, Field("", "pilot ratio R", DATASHEET, at_least=0)]
    cracking_pressure: Annotated[float, Field("Pa", "setting p_c", DATASHEET, above=0)]
    opening_range: Annotated[float, Field("Pa", "h, from cracking to wide open", DATASHEET, above=0)]
    rated_flow: Annotated[float, Field("m^3/s", "flow Q_n of the relief stage wide open", DATASHEET, above=0)]
    rated_drop: Annotated[float, Field("Pa", "drop p_n at that flow", DATASHEET, above=0)]
    check_valve: CheckFlow
    volume: Annotated[float, Field("m^3", "oil V between the valve and the drive", above=0)]
    oil: Oil
    drive: Drive = ValveOnSupply()
    in_line_b: Annotated[bool, Field("", "whether it stands in the line of B, not of A")] = False
    transition_drop: Annotated[
        float, Field("Pa", "drop d_t below which the flow is laminar", CHOSEN, at_least=0)
    ] = 1e5
    start_pressure: Annotated[
        float,
        Field("Pa", "pressure behind the valve at the start", "the chamber's", above=-ATMOSPHERE, auto=OPEN),
    ] = OPEN

    def check(self) -> None:
        ratio = getattr(self.check_valve, "pilot_ratio", 0.0)
        if ratio != 0.0:
            raise ParameterError("check_valve.pilot_ratio", ratio, "must be 0: it has no pilot here")

    def at_rest(self, line: Pressures, pressure_a: float, pressure_b: float) -> "Counterbalance":
        """The valve with the start pressure that was left open: its chamber's, which lets nothing flow."""
        chamber = pressure_b if self.in_line_b else pressure_a
        behind = chamber if self.start_pressure == OPEN else self.start_pressure
        ends = (pressure_a, behind) if self.in_line_b else (behind, pressure_b)
        return self._replace(start_pressure=behind, drive=at_ports(self.drive, line, *ends))

    def init(self) -> CounterbalanceState:
        return CounterbalanceState(self.start_pressure, self.drive.init())

    def deriv(
        self, s: CounterbalanceState, feed: Feed, pressure_a: float, pressure_b: float
    ) -> CounterbalanceState:
        end_a = ops.where(self.in_line_b, pressure_a, s.pressure)
        end_b = ops.where(self.in_line_b, s.pressure, pressure_b)
        fed = self.drive.flows(s.drive, feed, end_a, end_b)
        stored = ops.where(self.in_line_b, -fed.b, fed.a) - self.into_chamber(s, pressure_a, pressure_b)
        return CounterbalanceState(
            self.oil.bulk_modulus(s.pressure) / self.volume * stored,
            self.drive.deriv(s.drive, feed, end_a, end_b),
        )

    def flows(self, s: CounterbalanceState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        end_a = ops.where(self.in_line_b, pressure_a, s.pressure)
        end_b = ops.where(self.in_line_b, s.pressure, pressure_b)
        fed = self.drive.flows(s.drive, feed, end_a, end_b)
        passed = self.into_chamber(s, pressure_a, pressure_b)
        return PortFlows(
            ops.where(self.in_line_b, fed.a, passed),
            ops.where(self.in_line_b, -passed, fed.b),
            supply=fed.supply,
            tank=fed.tank,
        )

    def power(
        self, s: CounterbalanceState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        end_a = ops.where(self.in_line_b, pressure_a, s.pressure)
        end_b = ops.where(self.in_line_b, s.pressure, pressure_b)
        return self.drive.power(s.drive, feed, self.drive.flows(s.drive, feed, end_a, end_b), end_a, end_b)

    def into_chamber(self, s: CounterbalanceState, pressure_a: float, pressure_b: float) -> float:
        """What flows through the valve into its chamber [m^3/s]."""
        chamber = ops.where(self.in_line_b, pressure_b, pressure_a)
        pilot = ops.where(self.in_line_b, pressure_a, pressure_b)
        let_off = self.rated_flow * self.opening(chamber, pilot, s.pressure) * self.root(chamber - s.pressure)
        return self.check_valve.flow(s.pressure - chamber) - let_off / self.root(self.rated_drop)

    def opening(self, chamber: float, pilot: float, behind: float) -> float:
        """How far the relief stage is open, 0 to 1."""
        beyond = chamber - behind + self.pilot_ratio * (pilot - behind) - self.cracking_pressure
        return ops.clip(beyond / self.opening_range, 0.0, 1.0)

    def root(self, drop: float) -> float:
        """The drop's root [Pa^(1/2)] with its sign, linear below the transition drop."""
        return ops.smooth_root(drop, self.transition_drop)
