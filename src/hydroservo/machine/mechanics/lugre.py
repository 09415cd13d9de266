"""Friction of bristles that bend before they slide."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Friction, role
from hydroservo.machine.mechanics.dry import check_breakaway

E = math.e


class LuGreState(NamedTuple):
    """The mean bending of the bristles."""

    deflection: Annotated[float, Field("m", "bristle deflection z")]


@role(Friction)
class LuGre(NamedTuple):
    """Friction with memory: presliding displacement, frictional lag, breakaway that depends on the rate.

    With z the mean deflection of the surfaces' bristles::

        dz/dt = v - sigma_0 |v|/g(v) z
        g(v)  = F_c + (F_s - F_c) e^(-(v/v_s)^2)
        F     = sigma_0 z + sigma_1 dz/dt + sigma_2 v

    Steady sliding gives F = g(v) sgn(v) + sigma_2 v, and |sigma_0 z| never passes the larger of F_s and F_c
    once below it.

    Source: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40(3), 1995. With
    sigma_1 (F_s - F_c) <= sigma_2 F_c it takes energy from every motion: Barahanov and Ortega, IEEE Trans.
    Automatic Control 45(4), 2000.
    Fails to hold still under a force that varies below the breakaway force: it creeps, where an
    :class:`ElastoPlastic` holds. Its rate
    sigma_0 |v|/g grows with velocity, and with it the need for short integration steps.
    """

    bristle_stiffness: Annotated[float, Field("N/m", "bristle stiffness sigma_0", above=0)]
    bristle_damping: Annotated[float, Field("N s/m", "bristle damping sigma_1", at_least=0)]
    coulomb: Annotated[float, Field("N", "Coulomb friction F_c", above=0)]
    breakaway: Annotated[float, Field("N", "breakaway force F_s", above=0)]
    stribeck_velocity: Annotated[float, Field("m/s", "Stribeck velocity v_s", above=0)]
    viscous: Annotated[float, Field("N s/m", "viscous damping sigma_2", "0: none", at_least=0)] = 0.0

    def check(self) -> None:
        check_breakaway(self.coulomb, self.breakaway)

    def init(self) -> LuGreState:
        return LuGreState(0.0)

    def deriv(self, s: LuGreState, velocity: float) -> LuGreState:
        pull = self.bristle_stiffness * s.deflection
        return LuGreState(velocity - ops.absolute(velocity) * pull / self.sliding(velocity))

    def force(self, s: LuGreState, velocity: float, net: float, mass: float) -> float:
        return self.force_of(s, self.deriv(s, velocity).deflection, velocity)

    def force_of(self, s: LuGreState, bending: float, velocity: float) -> float:
        """F, of bristles whose deflection changes by ``bending`` [m/s]."""
        return (
            self.bristle_stiffness * s.deflection + self.bristle_damping * bending + self.viscous * velocity
        )

    def sliding(self, velocity: float) -> float:
        """g(v), dry friction in steady sliding [N]."""
        ratio = velocity * (1.0 / self.stribeck_velocity)
        return self.coulomb + (self.breakaway - self.coulomb) * ops.power(E, -(ratio * ratio))

    def simplified(self) -> float:
        return self.viscous
