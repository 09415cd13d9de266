"""The square-root law of a pair of metering edges."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN
from hydroservo.core.roles import MeteringEdges, role
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.core.sources import DATASHEET

ROOT_2 = math.sqrt(2.0)
LEAST_DENSITY = 1.0  # [kg/m^3], about that of air: less is another unit
LARGEST_OPENING = 1.0  # [m], more than any spool's

DischargeCoefficient = Annotated[float, Field("", "discharge coefficient C_d", "of sharp edges", above=0)]
Density = Annotated[float, Field("kg/m^3", "oil density rho", "of mineral oil", at_least=LEAST_DENSITY)]
RatedDensity = Annotated[
    float,
    Field("kg/m^3", "oil density at the rated flow", "that of the oil", at_least=LEAST_DENSITY, auto=OPEN),
]
RatedFlow = Annotated[float, Field("m^3/s", "flow at the rated point, without load", DATASHEET, above=0)]
RatedDrop = Annotated[float, Field("Pa", "rated pressure drop over both edges", DATASHEET, above=0)]
RatedOpening = Annotated[
    float, Field("m", "spool position at the rated flow", DATASHEET, above=0, at_most=LARGEST_OPENING)
]


@role(MeteringEdges)
class Orifice(NamedTuple):
    """Turbulent flow through sharp metering edges, matched, symmetric and critically lapped.

    Through two of them in series with a load, Q_L = C_d w x_v sqrt((p_s - p_r - sgn(x_v) p_L)/rho), and
    nothing where the load pressure exceeds the supply's. Through each of the four that are open, from a
    pressure p_1 to p_2, Q = C_d w |x_v| sgn(p_1 - p_2) sqrt(2 |p_1 - p_2|/rho), which also flows back.

    Source: eq. (2) of doi:10.1007/s42401-021-00087-w; Merritt, Hydraulic Control Systems, 1967, ch. 5.
    Fails at small drops, where the flow is laminar (its slope at a vanishing drop is infinite), and near
    the spool's centre, where real edges leak or overlap; see FourEdges.
    """

    discharge_coefficient: DischargeCoefficient
    area_gradient: Annotated[float, Field("m", "area gradient w", above=0)]
    density: Density

    @classmethod
    def rated(
        cls,
        rated_flow: RatedFlow,
        rated_drop: RatedDrop,
        rated_opening: RatedOpening,
        discharge_coefficient: DischargeCoefficient = 0.62,
        density: Density = 850.0,
        rated_density: RatedDensity = OPEN,
    ) -> "Orifice":
        """The edges that pass a datasheet's rated flow.

        Rated drops are over both edges together, usually 70 bar for servo valves and 10 bar for proportional
        ones. The flow is rated with an oil of a density of its own where that is given.
        """
        edges = cls(discharge_coefficient, 1.0, density if rated_density == OPEN else rated_density)
        area_gradient = rated_flow / edges.flow(rated_opening, rated_drop, 0.0)
        return edges._replace(area_gradient=area_gradient, density=density)

    def flow_per_opening(self, drop: float) -> float:
        """Load flow per spool opening at a pressure drop over both edges [m^2/s]."""
        return self.conductance() * ops.sqrt(ops.maximum(drop, 0.0))

    def conductance(self) -> float:
        """Load flow per spool opening and root of the pressure drop, C_d w/sqrt(rho) [m^2/(s Pa^(1/2))]."""
        return self.discharge_coefficient * self.area_gradient * ops.sqrt(1.0 / self.density)

    def flow(self, opening: float, supply_drop: float, load_pressure: float) -> float:
        """Q_L [m^3/s]."""
        drop = supply_drop - ops.sign(opening) * load_pressure
        return opening * self.conductance() * ops.sqrt(ops.maximum(drop, 0.0))

    def port_flows(self, opening: float, line: Pressures, pressure_a: float, pressure_b: float) -> PortFlows:
        """The flows through the four edges [m^3/s]."""
        into_a = ops.where(opening > 0.0, line.supply, line.tank) - pressure_a
        out_of_b = pressure_b - ops.where(opening > 0.0, line.tank, line.supply)
        size = ROOT_2 * self.conductance() * ops.absolute(opening)
        a = size * ops.copysign(ops.sqrt(ops.absolute(into_a)), into_a)
        b = size * ops.copysign(ops.sqrt(ops.absolute(out_of_b)), out_of_b)
        return PortFlows(a, b, supply=ops.where(opening > 0.0, a, -b), tank=ops.where(opening > 0.0, b, -a))

    def simplified(self) -> "Orifice":
        """What a design model takes it for: itself."""
        return self


def check_opens(edges: MeteringEdges, max_opening: float) -> None:
    """Refuse metering edges that overlap by more than their spool travels, all or both of one way.

    Args:
        edges: what the spool opens.
        max_opening: how far the spool travels to either side [m].

    Raises:
        ParameterError: the valve never opens.
    """
    lap = getattr(edges, "lap", 0.0)
    if not lap < max_opening:
        raise ParameterError("orifice.lap", lap, f"must be below max_opening, {max_opening:g} [m]")
    pa, pb = (getattr(edges, name, 0.0) for name in ("extra_lap_pa", "extra_lap_pb"))
    at, bt = (getattr(edges, name, 0.0) for name in ("extra_lap_at", "extra_lap_bt"))
    if not lap + min(pa, pb) < max_opening:
        raise shut("from the supply", "extra_lap_pa", pa, "extra_lap_pb", max_opening)
    if not lap + min(at, bt) < max_opening:
        raise shut("to the tank", "extra_lap_at", at, "extra_lap_bt", max_opening)


def shut(way: str, name: str, extra: float, other: str, max_opening: float) -> ParameterError:
    """That both edges of one way stay shut."""
    allowed = f"leaves no way {way}: with the lap, it or {other} must be below {max_opening:g} [m]"
    return ParameterError(f"orifice.{name}", extra, allowed)
