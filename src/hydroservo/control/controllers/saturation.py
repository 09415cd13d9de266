"""The limit of a command."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Limiter, role


@role(Limiter)
class Saturation(NamedTuple):
    """u held within +-limit.

    Source: the valve's input range, x_max/K_sv with the values of doi:10.1007/s42401-021-00087-w, Sec. 4.
    Fails to help a law with an integrator, which winds up behind it; see PI's anti-windup.
    """

    limit: Annotated[float, Field("V", "largest command", "x_max/K_sv of the paper", above=0)] = 10.0

    def apply(self, u: float) -> float:
        return ops.clip(u, -self.limit, self.limit)
