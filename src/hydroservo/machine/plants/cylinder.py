"""The cylinder with two chambers."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import Carried, EndStops, Friction, Mechanism, Oil, Plant, role
from hydroservo.core.signals import MachineOutputs, PortFlows, Pressures
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.mechanics.nothing_carried import NothingCarried, NothingCarriedState
from hydroservo.machine.mechanics.stops import Stops
from hydroservo.machine.mechanics.viscous import Viscous
from hydroservo.machine.plants.load_pressure import LoadPressurePlant
from hydroservo.machine.plants.stroke import check_start

FRICTION, STOPS, NOTHING = Viscous(), Stops(), NothingCarried()
LEAST_VOLUME = 0.01  # of a chamber's dead volume

StartPressureA = Annotated[
    float, Field("Pa", "pressure in chamber A at the start", "at rest", above=-ATMOSPHERE, auto=OPEN)
]
StartPressureB = Annotated[
    float, Field("Pa", "pressure in chamber B at the start", "at rest", above=-ATMOSPHERE, auto=OPEN)
]


class CylinderState(NamedTuple):
    """Motion, both chambers' pressures, what the friction remembers and how what is carried moves."""

    velocity: Annotated[float, Field("m/s", "piston velocity x1")]
    position: Annotated[float, Field("m", "piston position from the lower end of the stroke")]
    pressure_a: Annotated[float, Field("Pa", "pressure p_A in chamber A")]
    pressure_b: Annotated[float, Field("Pa", "pressure p_B in chamber B")]
    friction: Block
    carried: Block = NothingCarriedState()


@role(Plant)
class Cylinder(NamedTuple):
    """A cylinder of one or two rods with its two chambers, which moves a mechanism of inertia M.

    With V_A = V_0A + A_A x and V_B = V_0B + A_B (L_max - x) and the valve's flows Q_A into A, Q_B out of B::

        M(x) dv/dt = A_A p_A - A_B p_B - F_L - resistance + stops - friction
        dp_A/dt = beta_e(p_A)/V_A (Q_A - A_A v - C_i (p_A - p_B) - C_e max(p_A, 0))
        dp_B/dt = beta_e(p_B)/V_B (A_B v - Q_B + C_i (p_A - p_B) - C_e max(p_B, 0))

    Inertia and resistance are the mechanism's, with those of what it carries, which may swing by itself.
    Oil that leaks to the outside does not come back: a chamber below atmospheric pressure draws in no air.

    Start pressures that are left open ("auto") are those at which the piston rests under the load and the
    resistance at t = 0, and which a valve with matched edges holds: p_A + p_B = p_s + p_r. Where one is
    given, the other follows from rest alone.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (p_A + p_B = p_s) and 6; Jelali and Kroll,
    Hydraulic Servo-systems, 2003, ch. 4.
    Fails where the oil's own inertia in the lines matters. A piston beyond the end of its stroke by more
    than the dead volume holds (without stops) leaves a chamber with a hundredth of it.
    """

    area_a: Annotated[float, Field("m^2", "piston area A_A of chamber A", above=0)]
    area_b: Annotated[float, Field("m^2", "piston area A_B of chamber B", above=0)]
    stroke: Annotated[float, Field("m", "stroke L_max", above=0)]
    dead_volume_a: Annotated[float, Field("m^3", "dead volume V_0A of chamber A and its line", above=0)]
    dead_volume_b: Annotated[float, Field("m^3", "dead volume V_0B of chamber B and its line", above=0)]
    start_position: Annotated[float, Field("m", "piston position at the start", at_least=0)]
    oil: Oil
    mechanism: Mechanism
    internal_leakage: Annotated[
        float, Field("m^3/(s Pa)", "leakage coefficient C_i past the piston", "0: sealed", at_least=0)
    ] = 0.0
    external_leakage: Annotated[
        float, Field("m^3/(s Pa)", "leakage coefficient C_e of each chamber", CHOSEN, at_least=0)
    ] = 0.0
    start_pressure_a: StartPressureA = OPEN
    start_pressure_b: StartPressureB = OPEN
    friction: Friction = Viscous()
    stops: EndStops = Stops()
    carried: Carried = NothingCarried()

    @classmethod
    def from_diameters(
        cls,
        bore: Annotated[float, Field("m", "bore of the barrel", above=0)],
        rod: Annotated[float, Field("m", "diameter of the rod", above=0)],
        stroke: Annotated[float, Field("m", "stroke L_max", above=0)],
        oil: Oil,
        mechanism: Mechanism,
        rods: Annotated[int, Field("", "number of rods", at_least=1, at_most=2)] = 1,
        line_volume_a: Annotated[float, Field("m^3", "volume of the line to A", above=0)] = 2e-5,
        line_volume_b: Annotated[float, Field("m^3", "volume of the line to B", above=0)] = 2e-5,
        internal_leakage: Annotated[
            float, Field("m^3/(s Pa)", "leakage coefficient C_i past the piston", at_least=0)
        ] = 0.0,
        start_position: Annotated[
            float, Field("m", "piston position at the start; auto: mid-stroke", at_least=0, auto=OPEN)
        ] = OPEN,
        start_pressure_a: StartPressureA = OPEN,
        start_pressure_b: StartPressureB = OPEN,
        friction: Friction = FRICTION,
        stops: EndStops = STOPS,
        carried: Carried = NOTHING,
    ) -> "Cylinder":
        """A cylinder from what a catalogue lists of it, at rest at mid-stroke unless its start is given.

        A_A = pi bore^2/4 for one rod, which comes out of chamber B; else, as A_B = pi (bore^2 - rod^2)/4.

        Args:
            bore: inner diameter of the barrel [m].
            rod: diameter of the rod [m], below the bore.
            stroke: stroke [m].
            oil: its compressibility.
            mechanism: what the rod moves.
            rods: 1 or 2.
            line_volume_a: what chamber A holds at position 0, with its line up to the valve [m^3].
            line_volume_b: what chamber B holds at full stroke, with its line [m^3].
            internal_leakage: leakage past the piston [m^3/(s Pa)]; a sealed one has none.
            start_position: of the piston [m].
            start_pressure_a: in chamber A [Pa], gauge.
            start_pressure_b: in chamber B [Pa], gauge.
            friction: of the piston.
            stops: at both ends.
            carried: what the mechanism carries that moves by itself.

        Raises:
            ParameterError: the rod is not thinner than the bore.

        Source: geometry.
        """
        if not rod < bore:
            raise ParameterError("rod", rod, f"must be below the bore, {bore:g} [m]")
        annulus = 0.25 * math.pi * (bore * bore - rod * rod)
        return cls(
            area_a=annulus if rods == 2 else 0.25 * math.pi * bore * bore,
            area_b=annulus,
            stroke=stroke,
            dead_volume_a=line_volume_a,
            dead_volume_b=line_volume_b,
            internal_leakage=internal_leakage,
            start_position=0.5 * stroke if start_position == OPEN else start_position,
            start_pressure_a=start_pressure_a,
            start_pressure_b=start_pressure_b,
            oil=oil,
            friction=friction,
            stops=stops,
            mechanism=mechanism,
            carried=carried,
        )

    def check(self) -> None:
        check_start(self.start_position, self.stroke)
        if hasattr(self.mechanism, "positions"):
            least, most = self.mechanism.positions()
            if not least <= 0.0 < self.stroke <= most:
                allowed = (
                    f"can be at {least:.4g} to {most:.4g} [m] only: "
                    f"its lengths do not go with the stroke, 0 to {self.stroke:g} [m]"
                )
                raise ParameterError("mechanism", type(self.mechanism).__name__, allowed)
        if hasattr(self.mechanism, "check_within"):
            self.mechanism.check_within(self.start_position, self.stroke)
        if hasattr(self.carried, "check_on"):
            self.carried.check_on(self.mechanism)
        for name in ("start_pressure_a", "start_pressure_b"):
            pressure = getattr(self, name)
            if pressure != OPEN and not pressure < self.oil.bulk_modulus(pressure):
                raise ParameterError(name, pressure, "must be below the oil's bulk modulus there [Pa]")

    def at_rest(self, line: Pressures, force: float) -> "Cylinder":
        """The cylinder with the start pressures that were left open.

        With F the force that the oil has to balance, A_A p_A - A_B p_B = F, both are p_m + p_d and p_m - p_d
        about the mean p_m of supply and tank, p_d = (F - (A_A - A_B) p_m)/(A_A + A_B).

        Args:
            line: the pressures at the valve at the start.
            force: the load at t = 0 [N].

        Raises:
            ParameterError: a pressure found is not between tank and supply: the machine cannot hold its load.
        """
        a, b, x = self.start_pressure_a, self.start_pressure_b, self.start_position
        if OPEN not in (a, b):
            return self
        weight = self.carried.resistance(self.carried.init(), self.mechanism, x, 0.0)
        held = force + weight - self.stops.force(x, 0.0, self.stroke)
        mean = 0.5 * (line.supply + line.tank)
        apart = (held - (self.area_a - self.area_b) * mean) / (self.area_a + self.area_b)
        if a == b:
            a, b = mean + apart, mean - apart
        elif a == OPEN:
            a = (held + self.area_b * b) / self.area_a
        else:
            b = (self.area_a * a - held) / self.area_b
        found = self._replace(start_pressure_a=a, start_pressure_b=b)
        for name in ("start_pressure_a", "start_pressure_b"):
            if getattr(self, name) == OPEN and not line.tank <= getattr(found, name) <= line.supply:
                allowed = (
                    f"rest under {held:.4g} [N] needs {getattr(found, name):.4g} [Pa], and between tank and "
                    f"supply are {line.tank:.4g} to {line.supply:.4g}; lower the load or give start pressures"
                )
                raise ParameterError(name, "auto", allowed)
        return found

    def init(self) -> CylinderState:
        return CylinderState(
            0.0,
            self.start_position,
            self.start_pressure_a,
            self.start_pressure_b,
            self.friction.init(),
            self.carried.init(),
        )

    def flows(self, s: CylinderState, ports: Ports) -> PortFlows:
        """What the drive passes at its two ports [m^3/s]."""
        return ports.flows(s.pressure_a, s.pressure_b)

    def deriv(self, s: CylinderState, flows: PortFlows, force: float) -> CylinderState:
        inertia = self.carried.inertia(s.carried, self.mechanism, s.position)
        net = (
            self.hydraulic_force(s)
            - force
            - self.carried.resistance(s.carried, self.mechanism, s.position, s.velocity)
            + self.stops.force(s.position, s.velocity, self.stroke)
        )
        friction = self.friction.force(s.friction, s.velocity, net, inertia)
        acceleration = (net - friction) * (1.0 / inertia)
        past_piston = self.internal_leakage * (s.pressure_a - s.pressure_b)
        into_a = flows.a - past_piston - self.outside(s.pressure_a)
        into_b = past_piston - flows.b - self.outside(s.pressure_b)
        return CylinderState(
            velocity=acceleration,
            position=s.velocity,
            pressure_a=self.stiffness_a(s) * (into_a - self.area_a * s.velocity),
            pressure_b=self.stiffness_b(s) * (into_b + self.area_b * s.velocity),
            friction=self.friction.deriv(s.friction, s.velocity),
            carried=self.carried.deriv(s.carried, self.mechanism, s.position, s.velocity, acceleration),
        )

    def hydraulic_force(self, s: CylinderState) -> float:
        """A_A p_A - A_B p_B [N]; of a state's rate, its rate."""
        return self.area_a * s.pressure_a - self.area_b * s.pressure_b

    def outputs(self, s: CylinderState, line: Pressures, force: float) -> MachineOutputs:
        """What sensors can see; the force at the rod is the mechanism's resistance and the external force."""
        met = self.carried.resistance(s.carried, self.mechanism, s.position, s.velocity) + force
        return MachineOutputs(
            s.velocity, self.hydraulic_force(s), s.position, s.pressure_a, s.pressure_b, met
        )

    def volume_a(self, position: float) -> float:
        """V_A, kept above a hundredth of the dead volume [m^3]."""
        return ops.maximum(self.dead_volume_a + self.area_a * position, LEAST_VOLUME * self.dead_volume_a)

    def volume_b(self, position: float) -> float:
        """V_B, kept above a hundredth of the dead volume [m^3]."""
        left = self.stroke - position
        return ops.maximum(self.dead_volume_b + self.area_b * left, LEAST_VOLUME * self.dead_volume_b)

    def stiffness_a(self, s: CylinderState) -> float:
        """Rise of p_A per oil that comes in, beta_e/V_A [Pa/m^3]."""
        return self.oil.bulk_modulus(s.pressure_a) / self.volume_a(s.position)

    def stiffness_b(self, s: CylinderState) -> float:
        """Rise of p_B per oil that comes in, beta_e/V_B [Pa/m^3]."""
        return self.oil.bulk_modulus(s.pressure_b) / self.volume_b(s.position)

    def outside(self, pressure: float) -> float:
        """What leaks out of a chamber to the outside [m^3/s]."""
        return self.external_leakage * ops.maximum(pressure, 0.0)

    def simplified(self) -> LoadPressurePlant:
        """The double-rod cylinder that a design model takes it for, about the start.

        Its area A is the mean of the two, its bulk modulus that at the mean of the start pressures, its
        leakage C_i + C_e/2. Its V_t is such that the oil's stiffness is the same, so that the natural
        frequency is: 4 A^2/V_t = A_A^2/V_A + A_B^2/V_B. For equal areas at mid-stroke V_t is V_A + V_B.

        Raises:
            ParameterError: the oil asks for start pressures that are left open; :meth:`at_rest` finds them.
        """
        bulk_modulus = self.oil.bulk_modulus(0.5 * (self.start_pressure_a + self.start_pressure_b))
        if not ops.isfinite(bulk_modulus):
            raise ParameterError("start_pressure_a", "auto", "must be found first, with at_rest(line, force)")
        area = 0.5 * (self.area_a + self.area_b)
        spring_a = self.area_a**2 / self.volume_a(self.start_position)
        spring_b = self.area_b**2 / self.volume_b(self.start_position)
        return LoadPressurePlant(
            mass=self.carried.inertia(self.carried.init(), self.mechanism, self.start_position),
            damping=self.friction.simplified(),
            piston_area=area,
            total_volume=4.0 * area**2 / (spring_a + spring_b),
            bulk_modulus=bulk_modulus,
            leakage=self.internal_leakage + 0.5 * self.external_leakage,
            stroke=self.stroke,
            start_position=self.start_position,
        )
