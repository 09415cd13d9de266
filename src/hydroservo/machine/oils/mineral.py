"""What the data sheet of a mineral oil says, and what that makes of it at other temperatures."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core.errors import ParameterError
from hydroservo.core.field import Field
from hydroservo.core.validation import checked

EXPANSION = 0.34878 * 1.8  # [kg/(m^3 K)] K_1 of lubricating oils, there in kg/(m^3 degF)
ICE_POINT = 273.15  # [K]
KELVIN_15, KELVIN_40, KELVIN_100 = ICE_POINT + 15.0, ICE_POINT + 40.0, ICE_POINT + 100.0
MM2_PER_S = 1e-6  # [m^2/s]
COLDEST, HOTTEST = 200.0, 500.0  # [K] beyond which a temperature is taken for one in degC or degF


class MineralOil(NamedTuple):
    """A lubricating oil by its density at 15 degC and its kinematic viscosities at 40 and 100 degC.

    With T the absolute temperature and dT = T - 288.15 K::

        rho(T) = rho_15 exp(-a dT (1 + 0.8 a dT))          a = K_1/rho_15, K_1 = 0.6278 kg/(m^3 K)
        lg lg(nu/(mm^2/s) + 0.7) = A - B lg(T/K)            A and B from the two viscosities

    It is no part of a loop: what it says of the oil at a temperature goes into ``density`` of the metering
    edges, and into leakages and viscous friction, which go with 1/mu and mu.

    Source: ASTM D1250-04, lubricating oils (density); ASTM D341, of Walther and Ubbelohde (viscosity).
    Fails below 2 mm^2/s, near the pour point, under pressures that thicken it (by some 2 % per 10 bar),
    and for oils whose viscosity falls with shear, as that of multigrade ones does.
    """

    density_15: Annotated[float, Field("kg/m^3", "density rho_15 at 15 degC", above=0)]
    viscosity_40: Annotated[float, Field("m^2/s", "kinematic viscosity at 40 degC", above=0)]
    viscosity_100: Annotated[float, Field("m^2/s", "kinematic viscosity at 100 degC", above=0)]

    def check(self) -> None:
        if not self.viscosity_100 < self.viscosity_40:
            allowed = f"must be below viscosity_40, {self.viscosity_40:g} [m^2/s]"
            raise ParameterError("viscosity_100", self.viscosity_100, allowed)

    def density(self, temperature: float) -> float:
        """rho [kg/m^3] at a temperature [K] and atmospheric pressure.

        Raises:
            ParameterError: the temperature is not from 200 to 500 K, or the oil has a number out of range.
        """
        checked(self)
        check_temperature("temperature", temperature)
        grown = EXPANSION / self.density_15 * (temperature - KELVIN_15)
        return self.density_15 * math.exp(-grown * (1.0 + 0.8 * grown))

    def kinematic_viscosity(self, temperature: float) -> float:
        """nu [m^2/s] at a temperature [K] and atmospheric pressure.

        Raises:
            ParameterError: the temperature is not from 200 to 500 K, or the oil has a number out of range.
        """
        checked(self)
        check_temperature("temperature", temperature)
        hot, cold = walther(self.viscosity_100), walther(self.viscosity_40)
        slope = (hot - cold) / math.log10(KELVIN_100 / KELVIN_40)
        found = cold + slope * math.log10(temperature / KELVIN_40)
        return float((10.0 ** (10.0**found) - 0.7) * MM2_PER_S)

    def viscosity(self, temperature: float) -> float:
        """mu = rho nu [Pa s] at a temperature [K] and atmospheric pressure.

        Raises:
            ParameterError: the temperature is not from 200 to 500 K, or the oil has a number out of range.
        """
        return self.density(temperature) * self.kinematic_viscosity(temperature)


def walther(viscosity: float) -> float:
    """lg lg of a kinematic viscosity [m^2/s], in mm^2/s and raised by 0.7."""
    return math.log10(math.log10(viscosity / MM2_PER_S + 0.7))


def check_temperature(name: str, temperature: float) -> None:
    """Refuse what cannot be an oil's absolute temperature.

    Args:
        name: of the number, for the message.
        temperature: the number [K].

    Raises:
        ParameterError: it is not from 200 to 500 K.
    """
    if not COLDEST <= temperature <= HOTTEST:
        raise ParameterError(name, temperature, f"must be from {COLDEST:g} to {HOTTEST:g} [K]")
