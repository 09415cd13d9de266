"""Dry friction that holds what it can hold."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Friction, role
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.mechanics.dry import check_breakaway


class StribeckState(NamedTuple):
    """Dry friction remembers nothing."""


@role(Friction)
class Stribeck(NamedTuple):
    """Coulomb friction with stiction, Stribeck's fall of it and viscous friction.

    With F_net the sum of all other forces on the mass m::

        F = b v + clip(F_net - b v + m v/tau_s, -F_max, F_max)
        F_max = F_c + (F_s - F_c)/(1 + (v/v_s)^2)

    The clipped force is the one that would bring the mass to rest within tau_s, as far as dry friction
    reaches: the set-valued law F_max Sgn(v) evaluated at v + tau_s dv/dt, its resolvent with step tau_s. So a
    mass at rest stays there, without creep, until |F_net| exceeds the breakaway force F_s; any steady sliding
    meets the full F_max; and what stops decays as e^(-t/tau_s). It adds a rate 1/tau_s to the machine, which
    the integration steps must follow.

    Source: Hess and Soom, Journal of Tribology 112(1), 1990 (the fall with velocity); Acary and Brogliato,
    Numerical Methods for Nonsmooth Dynamical Systems, 2008 (the implicit form of the set-valued law).
    Fails below a velocity change of tau_s (|F_net| + F_max)/m: where F_net reverses a motion, dry friction
    acts up to tau_s early and may then give back some of the energy it took, of the order of
    tau_s^2 F_max |F_net|/m a reversal. It has no presliding displacement; see LuGre.
    """

    coulomb: Annotated[float, Field("N", "Coulomb friction F_c", at_least=0)]
    breakaway: Annotated[float, Field("N", "breakaway force F_s", at_least=0)]
    stribeck_velocity: Annotated[float, Field("m/s", "Stribeck velocity v_s", above=0)]
    viscous: Annotated[float, Field("N s/m", "viscous damping coefficient b", "0: none", at_least=0)] = 0.0
    stop_time: Annotated[float, Field("s", "time tau_s in which it stops", CHOSEN, above=0)] = 1e-4

    def check(self) -> None:
        check_breakaway(self.coulomb, self.breakaway)

    def init(self) -> StribeckState:
        return StribeckState()

    def deriv(self, s: StribeckState, velocity: float) -> StribeckState:
        return s

    def force(self, s: StribeckState, velocity: float, net: float, mass: float) -> float:
        viscous, limit = self.viscous * velocity, self.limit(velocity)
        stopping = net - viscous + mass * (1.0 / self.stop_time) * velocity
        return viscous + ops.clip(stopping, -limit, limit)

    def limit(self, velocity: float) -> float:
        """F_max, the most that dry friction reaches [N]."""
        ratio = velocity * (1.0 / self.stribeck_velocity)
        return self.coulomb + (self.breakaway - self.coulomb) / (1.0 + ratio * ratio)

    def simplified(self) -> float:
        return self.viscous
