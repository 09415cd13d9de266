"""Oil of one bulk modulus that tears."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.roles import Oil, role
from hydroservo.core.sources import CHOSEN

LEAST = 1e-3  # [Pa] absolute: below it the oil is as soft as there


@role(Oil)
class CavitatingOil(NamedTuple):
    """Oil of one bulk modulus beta with a trace of free air, into which a torn chamber expands.

    With P = p + p_0 the absolute pressure, p_0 = 101325 Pa that of the atmosphere, and a the air's volume
    there as a share of the chamber's::

        1/beta_e = 1/beta + a p_0/P^2

    At P = sqrt(a p_0 beta), 0.3 bar for the default trace and 10,000 bar, both give alike; far above it the
    oil alone counts, far below the void: the pressure approaches absolute zero and never passes it, and the
    void closes after the volume that opened it. A supply's line is compressed by the same law.

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 2 (liquid and gas in series), the gas isothermal.
    Fails where much air softens the oil at working pressure; see AeratedOil. Below 1 mPa absolute,
    beta_e stays what it is there.
    """

    effective_bulk_modulus: Annotated[float, Field("Pa", "bulk modulus beta of the oil", above=0)]
    free_air: Annotated[
        float, Field("", "free air a at atmospheric pressure, share of the volume", CHOSEN, above=0, below=1)
    ] = 1e-5

    def bulk_modulus(self, pressure: float) -> float:
        absolute = ops.maximum(pressure + ATMOSPHERE, LEAST)
        void = self.free_air * ATMOSPHERE * self.effective_bulk_modulus
        return self.effective_bulk_modulus * (absolute * absolute) / (absolute * absolute + void)
