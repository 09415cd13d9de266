"""A supply whose pressures nothing disturbs."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Supply, role
from hydroservo.core.signals import Pressures


class IdealSupplyState(NamedTuple):
    """An ideal supply remembers nothing."""


@role(Supply)
class IdealSupply(NamedTuple):
    """Constant supply and return pressure, gauge, whatever the flow: p_s and p_r of the paper.

    The print lists p_r = 2 bar and uses p_s alone: pressures here are relative to the return line.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w.
    Fails where the pump's flow limit, the relief valve or the line volume matters; see PumpSupply.
    """

    supply_pressure: Annotated[float, Field("Pa", "supply pressure p_s", above=0)]
    return_pressure: Annotated[
        float, Field("Pa", "return pressure p_r", "eq. (2) has none", above=-ATMOSPHERE)
    ] = 0.0

    def check(self) -> None:
        if not self.supply_pressure > self.return_pressure:
            allowed = f"must be above return_pressure, {self.return_pressure:g} [Pa]"
            raise ParameterError("supply_pressure", self.supply_pressure, allowed)

    def init(self) -> IdealSupplyState:
        return IdealSupplyState()

    def deriv(self, s: IdealSupplyState, drawn: float) -> IdealSupplyState:
        return s

    def pressures(self, s: IdealSupplyState) -> Pressures:
        return Pressures(self.supply_pressure, self.return_pressure)

    def drop(self) -> float:
        """p_s - p_r [Pa], what the valve's two metering edges share with the load."""
        return self.supply_pressure - self.return_pressure

    def simplified(self) -> "IdealSupply":
        """What a design model takes it for: itself."""
        return self
