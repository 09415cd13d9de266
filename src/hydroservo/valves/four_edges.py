"""Four metering edges with lap, clearance and a laminar transition."""

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.errors import ParameterError
from hydroservo.field import OPEN
from hydroservo.roles import MeteringEdges, role
from hydroservo.signals import PortFlows, Pressures
from hydroservo.sources import CHOSEN
from hydroservo.valves.orifice import (
    LARGEST_OPENING,
    Density,
    DischargeCoefficient,
    Orifice,
    RatedDensity,
    RatedDrop,
    RatedFlow,
    RatedOpening,
)

__all__ = ["FourEdges"]

ROOT_2 = math.sqrt(2.0)
FINEST, FINEST_SHARE = 1e-24, 1e-15  # [Pa or m], and of the value, to which roots are found
MOST_STEPS = 10_000  # to a root; halving all the way from the largest number takes some thousand


def a_lap(meaning: str, source: str) -> Field:
    """The declaration of a lap."""
    return Field("m", meaning, source, at_least=-LARGEST_OPENING, at_most=LARGEST_OPENING)


AreaGradient = Annotated[float, Field("m", "area gradient w of port A's edges", above=0)]
Lap = Annotated[float, a_lap("overlap of each edge, underlap if negative", "critical lap")]
TransitionDrop = Annotated[
    float, Field("Pa", "drop over an edge below which the flow is laminar", CHOSEN, at_least=0)
]
AreaRatioB = Annotated[
    float, Field("", "area of the edges of port B over that of port A's", "symmetric", above=0)
]
ExtraLapPA = Annotated[float, a_lap("overlap of the edge P-A beyond the lap", "as lapped")]
ExtraLapAT = Annotated[float, a_lap("overlap of the edge A-T beyond the lap", "as lapped")]
ExtraLapPB = Annotated[float, a_lap("overlap of the edge P-B beyond the lap", "as lapped")]
ExtraLapBT = Annotated[float, a_lap("overlap of the edge B-T beyond the lap", "as lapped")]
NullLeakage = Annotated[float, Field("m^3/s", "flow from P to T at null, ports blocked", CHOSEN, at_least=0)]
NullPressure = Annotated[
    float,
    Field("Pa", "drop from P to T at which the null leakage is given", "none given", at_least=0),
]


@role(MeteringEdges)
class FourEdges(NamedTuple):
    """The edges P-A, A-T, P-B and B-T of a spool, each of which may flow either way.

    A spool at x opens P-A and B-T by e(x) and A-T and P-B by e(-x), and each passes Q under a drop d::

        e(x) = (z + sqrt(z^2 + 4 c^2))/2             z = x - lap, clearance c
        Q    = C_d w e sqrt(2/rho) d/(d^2 + d_t^2)^(1/4)

    For d far above the transition drop d_t that is the square-root law, far below it is laminar, with a
    finite slope. An edge that is open by far opens by z, a closed one leaks as one open by c^2/|z| would, and
    at z = 0 it is open by c. Port B's edges may have another area gradient, for a single rod. Each edge may
    have an extra lap of its own beyond that of all; one that overlaps by more than the spool travels stays
    shut.

    To a symmetric load, with p_A = (p_s + p_t + p_L)/2 and p_B = (p_s + p_t - p_L)/2, P-A and B-T have the
    drop (p_s - p_t - p_L)/2 and the others (p_s - p_t + p_L)/2: the same load flow passes both ports, as far
    as the edges have the same lap, and else it is that of port A.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (four-way spool valve); the two transitions are
    chosen here.
    Fails where the discharge coefficient changes with the opening, and for what a closed edge leaks under
    other drops than its clearance was found at: that leakage is laminar, so proportional to the drop.
    """

    discharge_coefficient: DischargeCoefficient
    area_gradient: AreaGradient
    density: Density
    lap: Lap = 0.0
    clearance: Annotated[
        float,
        Field(
            "m",
            "opening of an edge that is just closed, from leakage",
            CHOSEN,
            at_least=0,
            at_most=LARGEST_OPENING,
        ),
    ] = 1e-6
    transition_drop: TransitionDrop = 1e5
    area_ratio_b: AreaRatioB = 1.0
    extra_lap_pa: ExtraLapPA = 0.0
    extra_lap_at: ExtraLapAT = 0.0
    extra_lap_pb: ExtraLapPB = 0.0
    extra_lap_bt: ExtraLapBT = 0.0

    @classmethod
    def rated(
        cls,
        rated_flow: RatedFlow,
        rated_drop: RatedDrop,
        rated_opening: RatedOpening,
        null_leakage: NullLeakage = 0.0,
        supply_pressure: NullPressure = 0.0,
        lap: Lap = 0.0,
        transition_drop: TransitionDrop = 1e5,
        area_ratio_b: AreaRatioB = 1.0,
        discharge_coefficient: DischargeCoefficient = 0.62,
        density: Density = 850.0,
        extra_lap_pa: ExtraLapPA = 0.0,
        extra_lap_at: ExtraLapAT = 0.0,
        extra_lap_pb: ExtraLapPB = 0.0,
        extra_lap_bt: ExtraLapBT = 0.0,
        rated_density: RatedDensity = OPEN,
    ) -> "FourEdges":
        """The edges that pass a datasheet's rated flow and null leakage.

        Rated drops are over both edges together, usually 70 bar for servo valves and 10 bar for proportional
        ones. The rated flow is that out of port A without load, the null leakage that from P to T with the
        spool at 0 and the ports blocked, at a supply pressure that goes with it. Area gradient and clearance
        are found so that both come out, with an oil of the rated density where one is given; without a
        leakage there is no clearance.

        Raises:
            ParameterError: the spool does not open at its rated position, no clearance leaks that much, more
                leaks at null than flows when rated, or the leakage has no pressure.
        """
        if not null_leakage < rated_flow:
            raise ParameterError("null_leakage", null_leakage, f"must be below rated_flow, {rated_flow:.4g}")
        if null_leakage > 0.0 and not supply_pressure > 0.0:
            raise ParameterError("supply_pressure", supply_pressure, "must be above 0 with a null leakage")
        if not rated_opening > lap + extra_lap_pa:
            of_edge = f"must be above the lap of the edge P-A, {lap + extra_lap_pa:g} [m]"
            raise ParameterError("rated_opening", rated_opening, of_edge)
        edges = cls(
            discharge_coefficient,
            1.0,
            density if rated_density == OPEN else rated_density,
            lap,
            0.0,
            transition_drop,
            area_ratio_b,
            extra_lap_pa,
            extra_lap_at,
            extra_lap_pb,
            extra_lap_bt,
        )
        point = RatedPoint(rated_flow, rated_drop, rated_opening)
        edges = edges._replace(clearance=clearance_that_leaks(edges, point, null_leakage, supply_pressure))
        area_gradient = rated_flow / edges.flow(rated_opening, rated_drop, 0.0)
        return edges._replace(area_gradient=area_gradient, density=density)

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float:
        """Q_L [m^3/s] to a symmetric load through port A's edges."""
        forwards = self.uncovered(opening - self.extra_lap_pa) * self.root(
            0.5 * (supply_drop - load_pressure)
        )
        backwards = self.uncovered(-opening - self.extra_lap_at) * self.root(
            0.5 * (supply_drop + load_pressure)
        )
        return self.conductance() * (forwards - backwards)

    def port_flows(self, opening: float, line: Pressures, pressure_a: float, pressure_b: float) -> PortFlows:
        """The flows through the four edges [m^3/s]."""
        pa = self.conductance() * self.uncovered(opening - self.extra_lap_pa)
        at = self.conductance() * self.uncovered(-opening - self.extra_lap_at)
        pb = self.conductance() * self.uncovered(-opening - self.extra_lap_pb)
        bt = self.conductance() * self.uncovered(opening - self.extra_lap_bt)
        supply_a = pa * self.root(line.supply - pressure_a)
        a_tank = at * self.root(pressure_a - line.tank)
        supply_b = self.area_ratio_b * pb * self.root(line.supply - pressure_b)
        b_tank = self.area_ratio_b * bt * self.root(pressure_b - line.tank)
        return PortFlows(
            supply_a - a_tank, b_tank - supply_b, supply=supply_a + supply_b, tank=a_tank + b_tank
        )

    def uncovered(self, opening: float) -> float:
        """The opening of an edge without extra lap [m]: of A-T and P-B, that at -opening."""
        z = opening - self.lap
        return 0.5 * (z + ops.sqrt(z * z + 4.0 * self.clearance * self.clearance))

    def root(self, drop: float) -> float:
        """The drop's root [Pa^(1/2)] with its sign, linear below the transition drop."""
        return ops.smooth_root(drop, self.transition_drop)

    def conductance(self) -> float:
        """Flow through an edge per opening and root of its drop, C_d w sqrt(2/rho) [m^2/(s Pa^(1/2))]."""
        return ROOT_2 * self.discharge_coefficient * self.area_gradient * ops.sqrt(1.0 / self.density)

    def simplified(self) -> Orifice:
        """What a design model takes them for: critically lapped edges of the same size."""
        return Orifice(self.discharge_coefficient, self.area_gradient, self.density)


class RatedPoint(NamedTuple):
    """A flow that a datasheet gives, without load."""

    flow: RatedFlow
    drop: RatedDrop
    opening: RatedOpening


def clearance_that_leaks(
    edges: FourEdges, rated: RatedPoint, null_leakage: float, supply_pressure: float
) -> float:
    """The clearance with which edges of the rated flow leak so much at null [m].

    Args:
        edges: of any area gradient.
        rated: their rated point.
        null_leakage: from P to T, the ports blocked [m^3/s].
        supply_pressure: at which that is [Pa].

    Raises:
        ParameterError: none leaks so much.
    """
    from scipy.optimize import brentq

    def beyond(clearance: float) -> float:
        return leaking_share(edges._replace(clearance=clearance), rated, supply_pressure) - wanted

    wanted, widest = null_leakage / rated.flow, rated.opening + abs(edges.lap)
    least, most = beyond(0.0), beyond(widest)
    if not least <= 0.0 <= most:
        least, most = (rated.flow * (one + wanted) for one in (least, most))
        allowed = f"must be from {least:.3g} to {most:.3g} [m^3/s] with this lap and rated flow"
        raise ParameterError("null_leakage", null_leakage, allowed)
    return float(brentq(beyond, 0.0, widest, xtol=FINEST, rtol=FINEST_SHARE, maxiter=MOST_STEPS))


def leaking_share(edges: FourEdges, rated: RatedPoint, supply_pressure: float) -> float:
    """What leaks from P to T at null, the ports blocked, over the flow at the rated point."""
    line = Pressures(supply_pressure, 0.0)
    a = blocked_pressure(lambda p: edges.port_flows(0.0, line, p, p).a, supply_pressure)
    b = blocked_pressure(lambda p: -edges.port_flows(0.0, line, p, p).b, supply_pressure)
    return edges.port_flows(0.0, line, a, b).supply / edges.flow(rated.opening, rated.drop, 0.0)


def blocked_pressure(flow: Callable[[float], float], supply_pressure: float) -> float:
    """The pressure in a blocked port, where the flow out of it is 0 [Pa].

    That falls with the pressure: at 0 nothing flows to the tank, at the supply's pressure nothing from it.
    """
    from scipy.optimize import brentq

    if flow(0.5 * supply_pressure) == 0.0:  # as through edges that are shut
        return 0.5 * supply_pressure
    return float(brentq(flow, 0.0, supply_pressure, xtol=FINEST, rtol=FINEST_SHARE, maxiter=MOST_STEPS))
