"""A pressure relief valve by its flow-pressure curve."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Relief, role
from hydroservo.core.sources import DATASHEET

CrackingPressure = Annotated[float, Field("Pa", "pressure at which it opens", above=0)]
Override = Annotated[float, Field("Pa", "pressure beyond cracking at a flow", DATASHEET, above=0)]
OverrideFlow = Annotated[float, Field("m^3/s", "flow at the override", DATASHEET, above=0)]


@role(Relief)
class ReliefValve(NamedTuple):
    """Q = G max(p - p_c, 0): shut up to the cracking pressure p_c, then in proportion; it shuts as it opened.

    Source: Merritt, Hydraulic Control Systems, 1967 (pressure control valves in steady state).
    Fails where its spring and mass chatter, and where it reseats below the pressure at which it opened.
    """

    cracking_pressure: CrackingPressure
    gradient: Annotated[float, Field("m^3/(s Pa)", "flow per pressure beyond cracking", above=0)]

    @classmethod
    def from_override(
        cls, cracking_pressure: CrackingPressure, override: Override, flow: OverrideFlow
    ) -> "ReliefValve":
        """The valve that passes a flow Q at an override dp, as its datasheet shows: G = Q/dp.

        Raises:
            ParameterError: the override or the flow is not above 0.
        """
        if not override > 0.0:
            raise ParameterError("override", override, "must be above 0 [Pa]")
        if not flow > 0.0:
            raise ParameterError("flow", flow, "must be above 0 [m^3/s]")
        return cls(cracking_pressure, flow / override)

    def flow(self, pressure: float) -> float:
        """To the tank [m^3/s]."""
        return self.gradient * ops.maximum(pressure - self.cracking_pressure, 0.0)
