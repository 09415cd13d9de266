"""The square-root law of a pair of metering edges."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.sources import TSMC_EHA_2021

__all__ = ["Orifice"]


class Orifice(NamedTuple):
    """Turbulent flow through two equal metering edges in series.

    Q_L = C_d w x_v sqrt((p_s - p_r - sgn(x_v) p_L)/rho)

    Source: eq. (2) of doi:10.1007/s42401-021-00087-w; Merritt, Hydraulic Control Systems, 1967, ch. 5.
    No flow where the load pressure exceeds the supply's (the real one would flow back).
    Fails at small drops, where the flow is laminar: its slope in p_L is infinite at a vanishing drop.
    """

    discharge_coefficient: Annotated[
        float, Field("", "discharge coefficient C_d", TSMC_EHA_2021, above=0)
    ] = 0.62
    area_gradient: Annotated[float, Field("m", "area gradient w", TSMC_EHA_2021, above=0)] = 0.024
    density: Annotated[float, Field("kg/m^3", "oil density rho", TSMC_EHA_2021, above=0)] = 850.0

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
