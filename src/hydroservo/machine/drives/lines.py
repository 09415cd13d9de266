"""Long lines between what meters and the cylinder, in which the oil has mass."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.hooks import at_ports
from hydroservo.core.roles import Drive, Oil, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.drives.hoses import pipe
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply

VALVE = ValveOnSupply()
PHASE = 0.49  # of a wave in a cell [rad], at which it travels 1 % too slowly
MOST_CELLS = 40
WORKING = 50e5  # Pa, at which the speed of sound is taken: near 0, free air makes oil soft


class LinesState(NamedTuple):
    """Pressure and flow in the last cell of each line, and the state of the drive or the cells before it."""

    pressure_a: Annotated[float, Field("Pa", "pressure p_LA in line A")]
    pressure_b: Annotated[float, Field("Pa", "pressure p_LB in line B")]
    flow_a: Annotated[float, Field("m^3/s", "flow Q_A through line A, towards the cylinder")]
    flow_b: Annotated[float, Field("m^3/s", "flow Q_B through line B, from the cylinder")]
    drive: Block


@role(Drive)
class Lines(NamedTuple):
    """A cell of a long line at each port of another drive: oil that is compressed, then oil with mass.

    With the flows Q_DA and Q_DB of the drive at its end, and p_A and p_B at the other::

        dp_LA/dt = beta_e(p_LA)/V (Q_DA - Q_A)        dQ_A/dt = (p_LA - p_A - R Q_A)/I
        dp_LB/dt = beta_e(p_LB)/V (Q_B - Q_DB)        dQ_B/dt = (p_B - p_LB - R Q_B)/I

    ``from_dimensions`` makes a line of as many cells, each the drive of the next, as carry waves up to a
    frequency: pressure peaks behind a valve that shuts, and the columns of oil that a piston has to move. A
    piston of the area A feels the inertance as the mass I A^2.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 3; Krus, Weddfelt, Palmberg, Journal of Dynamic
    Systems, Measurement, and Control 116(1), 1994 (what lumped lines leave out). Friction is quasi-steady.
    Fails above the frequency that its cells carry; where friction that depends on frequency damps the waves
    faster; where the flow is turbulent (Re = 4 Q/(pi d nu) above some 2,300); and with a plant that is
    described by its load pressure, which is refused.
    """

    volume: Annotated[float, Field("m^3", "volume V of a cell", above=0)]
    inertance: Annotated[float, Field("kg/m^4", "inertance I of the oil in a cell", above=0)]
    resistance: Annotated[float, Field("Pa s/m^3", "laminar resistance R of a cell", at_least=0)]
    oil: Oil
    drive: Drive = ValveOnSupply()
    start_pressure_a: Annotated[
        float, Field("Pa", "pressure in A at the start", "the chamber's", above=-ATMOSPHERE, auto=OPEN)
    ] = OPEN
    start_pressure_b: Annotated[
        float, Field("Pa", "pressure in B at the start", "the chamber's", above=-ATMOSPHERE, auto=OPEN)
    ] = OPEN

    @classmethod
    def from_dimensions(
        cls,
        length: Annotated[float, Field("m", "length l of each line", above=0)],
        inner_diameter: Annotated[float, Field("m", "inner diameter d of each line", above=0)],
        kinematic_viscosity: Annotated[float, Field("m^2/s", "kinematic viscosity nu of the oil", above=0)],
        oil: Oil,
        density: Annotated[float, Field("kg/m^3", "oil density rho", "of mineral oil", above=0)] = 850.0,
        highest_frequency: Annotated[
            float, Field("Hz", "frequency up to which waves travel as they should", CHOSEN, above=0)
        ] = 100.0,
        drive: Drive = VALVE,
    ) -> "Lines":
        """Two lines of one size, in cells short enough for waves of the highest frequency to be 1 % slow.

        With the speed of sound c = sqrt(beta_e/rho) at 50 bar these are n = 2 pi f l/(0.49 c) cells, each
        with V = pi d^2 l/(4 n), I = 4 rho l/(pi d^2 n) and R = 128 rho nu l/(pi d^4 n).

        Raises:
            ParameterError: that takes more than 40 cells.
        """
        sound = math.sqrt(oil.bulk_modulus(WORKING) / density)
        count = max(math.ceil(2.0 * math.pi * highest_frequency * length / (PHASE * sound)), 1)
        if count > MOST_CELLS:
            highest = MOST_CELLS * PHASE * sound / (2.0 * math.pi * length)
            allowed = f"must be at most {highest:.4g} [Hz], which {MOST_CELLS} cells of such a line carry"
            raise ParameterError("highest_frequency", highest_frequency, allowed)
        lines = cls(*pipe(length / count, inner_diameter, kinematic_viscosity, density), oil, drive)
        for _ in range(count - 1):
            lines = lines._replace(drive=lines)
        return lines

    def at_rest(self, line: Pressures, pressure_a: float, pressure_b: float) -> "Lines":
        """The lines with the start pressures that were left open: the chambers', which let nothing flow."""
        a = pressure_a if self.start_pressure_a == OPEN else self.start_pressure_a
        b = pressure_b if self.start_pressure_b == OPEN else self.start_pressure_b
        return self._replace(start_pressure_a=a, start_pressure_b=b, drive=at_ports(self.drive, line, a, b))

    def init(self) -> LinesState:
        return LinesState(self.start_pressure_a, self.start_pressure_b, 0.0, 0.0, self.drive.init())

    def deriv(self, s: LinesState, feed: Feed, pressure_a: float, pressure_b: float) -> LinesState:
        fed = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        return LinesState(
            pressure_a=self.oil.bulk_modulus(s.pressure_a) / self.volume * (fed.a - s.flow_a),
            pressure_b=self.oil.bulk_modulus(s.pressure_b) / self.volume * (s.flow_b - fed.b),
            flow_a=(s.pressure_a - pressure_a - self.resistance * s.flow_a) / self.inertance,
            flow_b=(pressure_b - s.pressure_b - self.resistance * s.flow_b) / self.inertance,
            drive=self.drive.deriv(s.drive, feed, s.pressure_a, s.pressure_b),
        )

    def flows(self, s: LinesState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        fed = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        return PortFlows(s.flow_a, s.flow_b, supply=fed.supply, tank=fed.tank)

    def power(
        self, s: LinesState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        fed = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        return self.drive.power(s.drive, feed, fed, s.pressure_a, s.pressure_b)
