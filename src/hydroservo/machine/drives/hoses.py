"""Hoses between what meters and the cylinder."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.field import OPEN
from hydroservo.core.hooks import at_ports
from hydroservo.core.roles import Drive, Oil, role
from hydroservo.core.signals import Feed, PortFlows, Pressures
from hydroservo.machine.drives.valve_on_supply import ValveOnSupply

VALVE = ValveOnSupply()

StartPressureA = Annotated[
    float, Field("Pa", "pressure in hose A at the start", "the chamber's", above=-ATMOSPHERE, auto=OPEN)
]
StartPressureB = Annotated[
    float, Field("Pa", "pressure in hose B at the start", "the chamber's", above=-ATMOSPHERE, auto=OPEN)
]
Inertance = Annotated[
    float, Field("kg/m^4", "inertance of the oil in a hose, left out here", "0: not known", at_least=0)
]


def pipe(
    length: float, inner_diameter: float, kinematic_viscosity: float, density: float
) -> tuple[float, float, float]:
    """Volume [m^3], inertance [kg/m^4] and laminar resistance [Pa s/m^3] of a pipe of sizes in SI units."""
    area = 0.25 * math.pi * inner_diameter**2
    resistance = 128.0 * density * kinematic_viscosity * length / (math.pi * inner_diameter**4)
    return area * length, density * length / area, resistance


class HosesState(NamedTuple):
    """The pressures at the hoses' far ends, and the state of the drive there."""

    pressure_a: Annotated[float, Field("Pa", "pressure p_HA in hose A")]
    pressure_b: Annotated[float, Field("Pa", "pressure p_HB in hose B")]
    drive: Block


@role(Drive)
class Hoses(NamedTuple):
    """A hose in each line between another drive and the cylinder: a volume that takes oil, and a resistance.

    With the flows Q_A and Q_B of the drive at its end, at the pressures p_HA and p_HB there::

        dp_HA/dt = beta_e(p_HA)/V_HA (Q_A - (p_HA - p_A)/R_A)
        dp_HB/dt = beta_e(p_HB)/V_HB ((p_B - p_HB)/R_B - Q_B)

    (p_HA - p_A)/R_A flows into chamber A. Start pressures that are left open ("auto") are the chambers'.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 3 (laminar flow in pipes) and 6 (the continuity of a
    compressed volume).
    Fails where the flow is turbulent (Re = 4 Q/(pi d nu) above some 2,300), and where the oil's mass counts:
    in hoses long enough for waves, or whose oil weighs more than half as much as the load. A run warns of
    that where it knows the inertance; see Lines. A law's design model knows nothing of hoses, and a plant
    that is described by its load pressure neither keeps nor gives back what two hoses that differ pass
    differently.
    """

    volume_a: Annotated[float, Field("m^3", "volume V_HA of hose A", above=0)]
    volume_b: Annotated[float, Field("m^3", "volume V_HB of hose B", above=0)]
    resistance_a: Annotated[float, Field("Pa s/m^3", "laminar resistance R_A of hose A", above=0)]
    resistance_b: Annotated[float, Field("Pa s/m^3", "laminar resistance R_B of hose B", above=0)]
    oil: Oil
    drive: Drive = ValveOnSupply()
    start_pressure_a: StartPressureA = OPEN
    start_pressure_b: StartPressureB = OPEN
    inertance: Inertance = 0.0

    @classmethod
    def from_dimensions(
        cls,
        length: Annotated[float, Field("m", "length l of each hose", above=0)],
        inner_diameter: Annotated[float, Field("m", "inner diameter d of each hose", above=0)],
        kinematic_viscosity: Annotated[float, Field("m^2/s", "kinematic viscosity nu of the oil", above=0)],
        oil: Oil,
        density: Annotated[float, Field("kg/m^3", "oil density rho", "of mineral oil", above=0)] = 850.0,
        drive: Drive = VALVE,
        start_pressure_a: StartPressureA = OPEN,
        start_pressure_b: StartPressureB = OPEN,
    ) -> "Hoses":
        """Two hoses of one size: V = pi d^2 l/4 and R = 128 rho nu l/(pi d^4) (Hagen and Poiseuille).

        What they leave out is I = 4 rho l/(pi d^2).
        """
        volume, inertance, resistance = pipe(length, inner_diameter, kinematic_viscosity, density)
        sizes = volume, volume, resistance, resistance
        return cls(*sizes, oil, drive, start_pressure_a, start_pressure_b, inertance)

    def at_rest(self, line: Pressures, pressure_a: float, pressure_b: float) -> "Hoses":
        """The hoses with the start pressures that were left open: the chambers', which let nothing flow."""
        a = pressure_a if self.start_pressure_a == OPEN else self.start_pressure_a
        b = pressure_b if self.start_pressure_b == OPEN else self.start_pressure_b
        return self._replace(start_pressure_a=a, start_pressure_b=b, drive=at_ports(self.drive, line, a, b))

    def init(self) -> HosesState:
        return HosesState(self.start_pressure_a, self.start_pressure_b, self.drive.init())

    def deriv(self, s: HosesState, feed: Feed, pressure_a: float, pressure_b: float) -> HosesState:
        into = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        stored_a = into.a - self.into_a(s, pressure_a)
        stored_b = self.out_of_b(s, pressure_b) - into.b
        return HosesState(
            self.oil.bulk_modulus(s.pressure_a) / self.volume_a * stored_a,
            self.oil.bulk_modulus(s.pressure_b) / self.volume_b * stored_b,
            self.drive.deriv(s.drive, feed, s.pressure_a, s.pressure_b),
        )

    def flows(self, s: HosesState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        fed = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        return PortFlows(
            self.into_a(s, pressure_a), self.out_of_b(s, pressure_b), supply=fed.supply, tank=fed.tank
        )

    def load_flow(self, s: HosesState, feed: Feed, load_pressure: float) -> float:
        mean, half = 0.5 * (feed.line.supply + feed.line.tank), 0.5 * load_pressure
        return 0.5 * (self.into_a(s, mean + half) + self.out_of_b(s, mean - half))

    def power(
        self, s: HosesState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        into = self.drive.flows(s.drive, feed, s.pressure_a, s.pressure_b)
        return self.drive.power(s.drive, feed, into, s.pressure_a, s.pressure_b)

    def into_a(self, s: HosesState, pressure: float) -> float:
        """What flows through hose A into chamber A [m^3/s]."""
        return (s.pressure_a - pressure) / self.resistance_a

    def out_of_b(self, s: HosesState, pressure: float) -> float:
        """What flows out of chamber B through hose B [m^3/s]."""
        return (pressure - s.pressure_b) / self.resistance_b
