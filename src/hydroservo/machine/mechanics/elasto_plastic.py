"""Friction of bristles that bend and spring back before they creep."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Friction, role
from hydroservo.core.sources import CHOSEN
from hydroservo.machine.mechanics.lugre import LuGre, LuGreState


@role(Friction)
class ElastoPlastic(NamedTuple):
    """Friction that holds still under a force that varies below breakaway, where LuGre creeps.

    As for the :class:`LuGre` that it nests, but bristles slide only beyond the elastic share s of the
    deflection g(v)/sigma_0 of steady sliding, and only while they are bent further::

        dz/dt = v - a(q) sigma_0 |v|/g(v) z          q = sigma_0 |z|/g(v)
        a(q)  = 0                                    for q <= s, and where v and z have opposite signs
              = 1/2 + 1/2 sin(pi (q - (1 + s)/2)/(1 - s))   in between
              = 1                                    for q >= 1
        F     = sigma_0 z + sigma_1 dz/dt + sigma_2 v

    Forces up to s F_s are held by a spring, without drift. Steady sliding is that of LuGre.

    Source: Dupont, Hayward, Armstrong, Altpeter, IEEE Trans. Automatic Control 47(5), 2002. That the elastic
    range follows g(v), so that it reaches up to the breakaway force at rest, is chosen here.
    Fails to hold a varying force between s F_s and F_s: it creeps there. It needs steps as short as LuGre.
    """

    bristles: LuGre
    elastic_share: Annotated[
        float, Field("", "share s of the sliding deflection that is elastic", CHOSEN, above=0, below=1)
    ] = 0.9

    def init(self) -> LuGreState:
        return self.bristles.init()

    def deriv(self, s: LuGreState, velocity: float) -> LuGreState:
        sliding = self.bristles.deriv(s, velocity).deflection
        return LuGreState(velocity + self.plastic_share(s, velocity) * (sliding - velocity))

    def force(self, s: LuGreState, velocity: float, net: float, mass: float) -> float:
        return self.bristles.force_of(s, self.deriv(s, velocity).deflection, velocity)

    def plastic_share(self, s: LuGreState, velocity: float) -> float:
        """a, how much of LuGre's sliding there is, 0 to 1."""
        pull = self.bristles.bristle_stiffness * ops.absolute(s.deflection)
        ratio = pull / self.bristles.sliding(velocity)
        place = (ratio - 0.5 * (1.0 + self.elastic_share)) / (1.0 - self.elastic_share)
        between = 0.5 + 0.5 * ops.sin(math.pi * ops.clip(place, -0.5, 0.5))
        bending = velocity * s.deflection > 0.0
        return ops.where(bending, ops.where(ratio <= self.elastic_share, 0.0, between), 0.0)

    def simplified(self) -> float:
        return self.bristles.simplified()
