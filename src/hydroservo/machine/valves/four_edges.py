"""Four metering edges with lap, clearance and a laminar transition."""

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.formatting import quantity
from hydroservo.core.roles import EdgeShape, MeteringEdges, role
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.core.sources import CHOSEN, DATASHEET
from hydroservo.machine.valves.edge_curves import STRAIGHT, EdgeCurves
from hydroservo.machine.valves.orifice import (
    LARGEST_OPENING,
    Density,
    DischargeCoefficient,
    Orifice,
    RatedDensity,
    RatedDrop,
    RatedFlow,
    RatedOpening,
)
from hydroservo.machine.valves.straight_edges import StraightEdges

ROOT_2 = math.sqrt(2.0)
FINEST, FINEST_SHARE = 1e-24, 1e-15  # [Pa or m], and of the value, to which roots are found
STRAIGHT_EDGES = StraightEdges()
AGREEMENT = 0.01  # of two rated flows
MOST_STEPS = 10_000  # to a root; halving all the way from the largest number takes some thousand


def a_lap(meaning: str, source: str) -> Field:
    """The declaration of a lap."""
    return Field("m", meaning, source, at_least=-LARGEST_OPENING, at_most=LARGEST_OPENING)


def a_flow_curve(edge: str) -> Field:
    """The declaration of a flow over the share of the rated opening."""
    return Field(
        "m^3/s", f"flow {edge} at the rated drop, over the share of the rated opening", DATASHEET, over=""
    )


def an_area_curve(edge: str) -> Field:
    """The declaration of an area over the opening."""
    return Field("m^2", f"area of {edge}, over the opening", DATASHEET, over="m")


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
Clearance = Annotated[
    float,
    Field(
        "m",
        "opening of an edge that is just closed, from leakage",
        CHOSEN,
        at_least=0,
        at_most=LARGEST_OPENING,
    ),
]
Shape = Annotated[EdgeShape, Field("", "how the edges open as the spool moves", "straight")]
Regeneration = Annotated[bool, Field("", "whether the edge from B leads to P in place of T", "to T")]
OpenRatedFlow = Annotated[
    float,
    Field("m^3/s", "flow at the rated point, without load; auto: the curve's", DATASHEET, above=0, auto=OPEN),
]
FlowCurve = Annotated[Curve, a_flow_curve("out of port A")]
FlowCurvePA = Annotated[Curve, a_flow_curve("through P-A")]
FlowCurveAT = Annotated[Curve, a_flow_curve("through A-T")]
FlowCurvePB = Annotated[Curve, a_flow_curve("through P-B")]
FlowCurveBT = Annotated[Curve, a_flow_curve("through B-T")]
AreaCurve = Annotated[Curve, an_area_curve("each edge")]
AreaCurvePA = Annotated[Curve, an_area_curve("P-A")]
AreaCurveAT = Annotated[Curve, an_area_curve("A-T")]
AreaCurvePB = Annotated[Curve, an_area_curve("P-B")]
AreaCurveBT = Annotated[Curve, an_area_curve("B-T")]
NullLeakage = Annotated[float, Field("m^3/s", "flow from P to T at null, ports blocked", CHOSEN, at_least=0)]
NullPressure = Annotated[
    float, Field("Pa", "drop from P to T at which the null leakage is given", "none given", at_least=0)
]


@role(MeteringEdges)
class FourEdges(NamedTuple):
    """The edges P-A, A-T, P-B and B-T of a spool, each of which may flow either way.

    A spool at x opens P-A and B-T by e(x) and A-T and P-B by e(-x), and each passes Q under a drop d::

        e(x) = (z + sqrt(z^2 + 4 c^2))/2             z = h(x) - lap, clearance c
        Q    = C_d w e sqrt(2/rho) d/(d^2 + d_t^2)^(1/4)

    For d far above the transition drop d_t that is the square-root law, far below it is laminar, with a
    finite slope. An edge that is open by far opens by z, a closed one leaks as one open by c^2/|z| would, and
    at z = 0 it is open by c. The shape's h is x for straight edges, and a curve for notches. Port B's edges
    may have another area gradient, for a single rod. Each edge may have an extra lap of its own beyond that
    of all; one that overlaps by more than the spool travels stays shut.

    With regeneration the edge B-T leads to P in place of T. An extending rod then takes no more from the
    supply than what it displaces itself, Q_P = Q_A - Q_B, and pushes with its own area alone.

    To a symmetric load, with p_A = (p_s + p_t + p_L)/2 and p_B = (p_s + p_t - p_L)/2, P-A and B-T have the
    drop (p_s - p_t - p_L)/2, with regeneration -p_L/2, and the others (p_s - p_t + p_L)/2: the same load flow
    passes both ports, as far as the edges have the same lap and shape, and else it is that of port A.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 5 (four-way spool valve); the two transitions are
    chosen here.
    Fails where the discharge coefficient changes with the opening, in a design model of a curve or of
    regeneration, which is that of straight edges between P and T, and for what a closed edge leaks under
    other drops than its clearance was found at: that leakage is laminar, so proportional to the drop.
    """

    discharge_coefficient: DischargeCoefficient
    area_gradient: AreaGradient
    density: Density
    lap: Lap = 0.0
    clearance: Clearance = 1e-6
    transition_drop: TransitionDrop = 1e5
    area_ratio_b: AreaRatioB = 1.0
    extra_lap_pa: ExtraLapPA = 0.0
    extra_lap_at: ExtraLapAT = 0.0
    extra_lap_pb: ExtraLapPB = 0.0
    extra_lap_bt: ExtraLapBT = 0.0
    shape: Shape = STRAIGHT_EDGES
    regeneration: Regeneration = False

    @classmethod
    def rated(
        cls,
        rated_flow: OpenRatedFlow,
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
        flow_curve: FlowCurve = STRAIGHT,
        flow_curve_pa: FlowCurvePA = STRAIGHT,
        flow_curve_at: FlowCurveAT = STRAIGHT,
        flow_curve_pb: FlowCurvePB = STRAIGHT,
        flow_curve_bt: FlowCurveBT = STRAIGHT,
        shape: Shape = STRAIGHT_EDGES,
        regeneration: Regeneration = False,
    ) -> "FourEdges":
        """The edges that pass a datasheet's rated flow and null leakage.

        Rated drops are over both edges together, usually 70 bar for servo valves and 10 bar for proportional
        ones. The rated flow is that out of port A without load, the null leakage that from P to T with the
        spool at 0 and the ports blocked, at a supply pressure that goes with it. Area gradient and clearance
        are found so that both come out, with an oil of the rated density where one is given; without a
        leakage there is no clearance.

        A flow curve is the flow at the rated drop over the share of the rated opening, 0 to 100 % for both
        directions alike or -100 % to 100 %, the overlap in it: laps beside it must be 0. An edge may have a
        curve of its own, over its own opening. Shares of the rated flow are for the shape.

        Raises:
            ParameterError: the spool does not open at its rated position, no clearance leaks that much, more
                leaks at null than flows when rated, the leakage has no pressure, a curve is not one of edges
                or has another rated flow, laps or a shape beside it.
        """
        curves = EdgeCurves(
            "flow_curve", "m^3/s", flow_curve, flow_curve_pa, flow_curve_at, flow_curve_pb, flow_curve_bt
        )
        of_curves, of_curve = curves.of_share(rated_opening)
        if of_curve > 0.0:
            if not isinstance(shape, StraightEdges):
                raise ParameterError("shape", type(shape).__name__, "must not stand beside a flow curve")
            shape = of_curves
            rated_flow = agreed(rated_flow, of_curve)
            check_no_laps(lap, extra_lap_pa, extra_lap_at, extra_lap_pb, extra_lap_bt)
        elif rated_flow == OPEN:
            raise ParameterError("rated_flow", "auto", "must be a number without a flow curve")
        if not null_leakage < rated_flow:
            raise ParameterError("null_leakage", null_leakage, f"must be below rated_flow, {rated_flow:.4g}")
        if null_leakage > 0.0 and not supply_pressure > 0.0:
            raise ParameterError("supply_pressure", supply_pressure, "must be above 0 with a null leakage")
        if not rated_opening > lap + extra_lap_pa:
            of_edge = f"must be above the lap of the edge P-A, {lap + extra_lap_pa:g} [m]"
            raise ParameterError("rated_opening", rated_opening, of_edge)
        if not shape.openings(rated_opening).pa > 0.0:
            raise ParameterError("rated_opening", rated_opening, "must open the edge P-A of that shape")
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
            shape,
        )
        point = RatedPoint(rated_flow, rated_drop, rated_opening)
        edges = edges._replace(clearance=clearance_that_leaks(edges, point, null_leakage, supply_pressure))
        area_gradient = rated_flow / edges.flow(rated_opening, rated_drop, 0.0)
        return edges._replace(area_gradient=area_gradient, density=density, regeneration=regeneration)

    @classmethod
    def from_areas(
        cls,
        discharge_coefficient: DischargeCoefficient,
        density: Density,
        area_curve: AreaCurve = STRAIGHT,
        clearance: Clearance = 1e-6,
        transition_drop: TransitionDrop = 1e5,
        area_ratio_b: AreaRatioB = 1.0,
        area_curve_pa: AreaCurvePA = STRAIGHT,
        area_curve_at: AreaCurveAT = STRAIGHT,
        area_curve_pb: AreaCurvePB = STRAIGHT,
        area_curve_bt: AreaCurveBT = STRAIGHT,
        regeneration: Regeneration = False,
    ) -> "FourEdges":
        """The edges whose areas are known over the opening, as from a drawing of the spool's notches.

        The curve goes from 0 for both directions alike, or from below 0; an edge may have one of its own,
        over its own opening. A design model takes the edges for straight ones with the last point's area.

        Raises:
            ParameterError: there is no curve, or one is not one of edges.
        """
        curves = EdgeCurves(
            "area_curve", "m^2", area_curve, area_curve_pa, area_curve_at, area_curve_pb, area_curve_bt
        )
        shape, area = curves.over_opening()
        if area == 0.0:
            raise ParameterError("area_curve", "missing", "must be given, or one of each edge")
        edges = cls(discharge_coefficient, 1.0, density, 0.0, clearance, transition_drop, area_ratio_b)
        return edges._replace(
            area_gradient=area / curves.full_opening(), shape=shape, regeneration=regeneration
        )

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float:
        """Q_L [m^3/s] to a symmetric load through port A's edges."""
        opened = self.shape.openings(opening)
        driving = ops.where(self.regeneration, 0.0, supply_drop)
        forwards = self.uncovered(opened.pa - self.extra_lap_pa) * self.root(0.5 * (driving - load_pressure))
        backwards = self.uncovered(opened.at - self.extra_lap_at) * self.root(
            0.5 * (supply_drop + load_pressure)
        )
        return self.conductance() * (forwards - backwards)

    def port_flows(self, opening: float, line: Pressures, pressure_a: float, pressure_b: float) -> PortFlows:
        """The flows through the four edges [m^3/s]."""
        opened = self.shape.openings(opening)
        pa = self.conductance() * self.uncovered(opened.pa - self.extra_lap_pa)
        at = self.conductance() * self.uncovered(opened.at - self.extra_lap_at)
        pb = self.conductance() * self.uncovered(opened.pb - self.extra_lap_pb)
        bt = self.conductance() * self.uncovered(opened.bt - self.extra_lap_bt)
        supply_a = pa * self.root(line.supply - pressure_a)
        a_tank = at * self.root(pressure_a - line.tank)
        supply_b = self.area_ratio_b * pb * self.root(line.supply - pressure_b)
        behind = ops.where(self.regeneration, line.supply, line.tank)
        out_of_b = self.area_ratio_b * bt * self.root(pressure_b - behind)
        back = ops.where(self.regeneration, out_of_b, 0.0)
        return PortFlows(
            supply_a - a_tank,
            out_of_b - supply_b,
            supply=supply_a + supply_b - back,
            tank=a_tank + (out_of_b - back),
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


def agreed(rated_flow: float, of_curve: float) -> float:
    """The flow at the rated point, where a curve has it, too [m^3/s].

    Raises:
        ParameterError: the two differ.
    """
    if rated_flow == OPEN or abs(rated_flow - of_curve) <= AGREEMENT * of_curve:
        return of_curve
    shown = quantity(of_curve, "m^3/s")
    allowed = f'must be that of the flow curve, {shown}, or "auto"; rated_drop scales the curve'
    raise ParameterError("rated_flow", quantity(rated_flow, "m^3/s"), allowed)


def check_no_laps(lap: float, *extra: float) -> None:
    """Refuse laps beside a flow curve.

    Raises:
        ParameterError: there is one.
    """
    if lap != 0.0 or any(extra):
        value = lap or next(one for one in extra if one)
        raise ParameterError("lap", value, "must be 0 beside a flow curve, which has the overlap in it")


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
