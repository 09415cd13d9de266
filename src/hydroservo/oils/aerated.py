"""Oil with entrained air, which also bounds the pressure of a torn chamber."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.constants import ATMOSPHERE
from hydroservo.roles import Oil, role
from hydroservo.sources import CHOSEN

__all__ = ["AeratedOil"]

LEAST = 1e-3  # [Pa] absolute: below it the oil is as soft as there


@role(Oil)
class AeratedOil(NamedTuple):
    """Liquid with free air in it, beta_e = -V dp/dV of the two together.

    With P = p + p_0 the absolute pressure, p_0 = 101325 Pa that of the atmosphere and alpha the air's
    volume there as a share of the mixture's, the volume relative to that at p_0 is::

        V(P) = (1 - alpha)/(1 + (P - p_0)/beta_l) + alpha (p_0/P)^(1/n)

    The liquid's own bulk modulus is thus beta_l + P - p_0. The gas follows P V^n: n = 1 is isothermal,
    n = 1.4 adiabatic.

    A chamber that is torn open does not lose oil, its air expands: beta_e tends to n P, so the pressure
    approaches absolute zero and never passes it, and the void closes after exactly the volume that opened
    it. That is this model's cavitation.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 2 (liquid and gas in series); the liquid's
    volume law is chosen here: it costs no exponential, and its bulk modulus rises with pressure as that
    of real oils does, but less.
    Fails where air dissolves or comes out of solution, at the vapour's pressure, which it ignores, and
    below 1 mPa absolute, where beta_e stays what it is there.
    """

    liquid_bulk_modulus: Annotated[
        float, Field("Pa", "bulk modulus beta_l of the liquid at atmospheric pressure", CHOSEN, at_least=1e6)
    ] = 1.4e9
    air_content: Annotated[
        float, Field("", "volume share of free air at atmospheric pressure", CHOSEN, above=0, below=1)
    ] = 0.005
    polytropic_index: Annotated[
        float, Field("", "polytropic index n of the air", "1.4: adiabatic", at_least=1, at_most=2)
    ] = 1.4

    def bulk_modulus(self, pressure: float) -> float:
        absolute = ops.maximum(pressure + ATMOSPHERE, LEAST)
        liquid = self.liquid_bulk_modulus + (absolute - ATMOSPHERE)
        expansion = ops.power(ATMOSPHERE / absolute, 1.0 / self.polytropic_index)
        ratio = self.air_content * expansion * liquid / ((1.0 - self.air_content) * self.liquid_bulk_modulus)
        gas = self.polytropic_index * absolute
        return (1.0 + ratio) * liquid * gas / (gas + ratio * liquid)
