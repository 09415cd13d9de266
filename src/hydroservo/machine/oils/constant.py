"""Oil of one bulk modulus."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Oil, role


@role(Oil)
class ConstantOil(NamedTuple):
    """beta_e = -V dp/dV is the same at every pressure: V = V_0 exp(-p/beta_e).

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w.
    Fails where a chamber is torn open: its pressure then falls below absolute zero; and below some 50 bar,
    where entrained air softens the oil; see AeratedOil.
    """

    effective_bulk_modulus: Annotated[float, Field("Pa", "effective bulk modulus beta_e", above=0)]

    def bulk_modulus(self, pressure: float) -> float:
        return self.effective_bulk_modulus
