"""A pressure relief valve by its flow-pressure curve."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.sources import CHOSEN, TSMC_EHA_2021

__all__ = ["ReliefValve"]


class ReliefValve(NamedTuple):
    """Q = G max(p - p_c, 0): shut up to the cracking pressure p_c, then in proportion; it shuts as it opened.

    A datasheet's override dp at a flow Q gives the gradient G = Q/dp.

    Source: Merritt, Hydraulic Control Systems, 1967 (pressure control valves in steady state).
    Fails where its spring and mass chatter, and where it reseats below the pressure at which it opened.
    """

    cracking_pressure: Annotated[float, Field("Pa", "pressure at which it opens", TSMC_EHA_2021, above=0)] = (
        40e5
    )
    gradient: Annotated[float, Field("m^3/(s Pa)", "flow per pressure beyond cracking", CHOSEN, above=0)] = (
        2.5e-10
    )

    def flow(self, pressure: float) -> float:
        """To the tank [m^3/s]."""
        return self.gradient * ops.maximum(pressure - self.cracking_pressure, 0.0)
