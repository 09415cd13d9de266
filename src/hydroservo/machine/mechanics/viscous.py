"""Friction in proportion to velocity."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Friction, role


class ViscousState(NamedTuple):
    """Viscous friction remembers nothing."""


@role(Friction)
class Viscous(NamedTuple):
    """F = b v.

    Source: eq. (3) of doi:10.1007/s42401-021-00087-w.
    Fails near rest, where seals stick; see Stribeck and LuGre.
    """

    coefficient: Annotated[float, Field("N s/m", "viscous damping b", "0: none", at_least=0)] = 0.0

    def init(self) -> ViscousState:
        return ViscousState()

    def deriv(self, s: ViscousState, velocity: float) -> ViscousState:
        return s

    def force(self, s: ViscousState, velocity: float, net: float, mass: float) -> float:
        return self.coefficient * velocity

    def simplified(self) -> float:
        return self.coefficient
