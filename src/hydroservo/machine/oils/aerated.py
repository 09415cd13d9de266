"""Oil with entrained air, which also bounds the pressure of a torn chamber."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Oil, role
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.oils.mineral import check_temperature

AirContent = Annotated[
    float, Field("", "volume share of free air at atmospheric pressure", CHOSEN, above=0, below=1)
]
PolytropicIndex = Annotated[
    float, Field("", "polytropic index n of the air", "1.4: adiabatic", at_least=1, at_most=2)
]
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
    air_content: AirContent = 0.005
    polytropic_index: PolytropicIndex = 1.4

    @classmethod
    def at_temperature(
        cls,
        temperature: Annotated[float, Field("K", "temperature T of the oil", at_least=200, at_most=500)],
        cold: Annotated[
            float, Field("K", "temperature T_1 of the first bulk modulus", at_least=200, at_most=500)
        ],
        cold_bulk_modulus: Annotated[float, Field("Pa", "bulk modulus of the liquid at T_1", at_least=1e6)],
        hot: Annotated[float, Field("K", "temperature T_2 of the second", at_least=200, at_most=500)],
        hot_bulk_modulus: Annotated[float, Field("Pa", "bulk modulus of the liquid at T_2", at_least=1e6)],
        air_content: AirContent = 0.005,
        polytropic_index: PolytropicIndex = 1.4,
    ) -> "AeratedOil":
        """The oil at a temperature, from bulk moduli of its liquid at two others, at atmospheric pressure.

        Its logarithm falls linearly: beta = beta_1 (beta_2/beta_1)^((T - T_1)/(T_2 - T_1)).
        Quick changes ask for adiabatic bulk moduli, which are those that the speed of sound gives.

        Raises:
            ParameterError: a temperature is not from 200 to 500 K, the two are not apart, or the hotter oil
                is the stiffer one.
        """
        for name, one in (("temperature", temperature), ("cold", cold), ("hot", hot)):
            check_temperature(name, one)
        if not hot > cold:
            raise ParameterError("hot", hot, f"must be above cold, {cold:g} [K]")
        if not hot_bulk_modulus < cold_bulk_modulus:
            allowed = f"must be below cold_bulk_modulus, {cold_bulk_modulus:g} [Pa]"
            raise ParameterError("hot_bulk_modulus", hot_bulk_modulus, allowed)
        share = (temperature - cold) / (hot - cold)
        liquid = cold_bulk_modulus * (hot_bulk_modulus / cold_bulk_modulus) ** share
        return cls(liquid, air_content, polytropic_index)

    def bulk_modulus(self, pressure: float) -> float:
        absolute = ops.maximum(pressure + ATMOSPHERE, LEAST)
        liquid = self.liquid_bulk_modulus + (absolute - ATMOSPHERE)
        expansion = ops.power(ATMOSPHERE / absolute, 1.0 / self.polytropic_index)
        ratio = self.air_content * expansion * liquid / ((1.0 - self.air_content) * self.liquid_bulk_modulus)
        gas = self.polytropic_index * absolute
        return (1.0 + ratio) * liquid * gas / (gas + ratio * liquid)
