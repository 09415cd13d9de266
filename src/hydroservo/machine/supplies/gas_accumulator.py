"""A gas that stores oil under pressure."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.roles import Accumulator, role
from hydroservo.core.sources import CHOSEN


@role(Accumulator)
class GasAccumulator(NamedTuple):
    """A bladder filled with gas, which the oil compresses above the precharge pressure.

    With absolute pressures, V_0 the gas volume at the precharge p_0 (which is given as gauge), and
    p V^n = p_0 V_0^n::

        dV_oil/dp = V_0/(n p) (p_0/p)^(1/n)    for p > p_0, else 0

    Source: the polytropic change of state of an ideal gas, in any textbook of thermodynamics.
    Fails beyond some 200 bar, where nitrogen is no ideal gas, and where heat has time to flow: n is no
    constant then, but lies between 1 (slow) and 1.4 (fast).
    """

    precharge: Annotated[float, Field("Pa", "precharge pressure, gauge", above=0)]
    gas_volume: Annotated[float, Field("m^3", "gas volume at the precharge", above=0)]
    exponent: Annotated[float, Field("", "polytropic exponent", CHOSEN, at_least=1, at_most=2)] = 1.2

    def compliance(self, pressure: float) -> float:
        """Oil taken in per pressure [m^3/Pa]."""
        gas, precharge = pressure + ATMOSPHERE, self.precharge + ATMOSPHERE
        held = ops.maximum(gas, precharge)
        volume = self.gas_volume * ops.power(precharge / held, 1.0 / self.exponent)
        return ops.where(gas > precharge, volume / (self.exponent * held), 0.0)
