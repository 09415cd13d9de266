"""Ends of the stroke that the piston strikes."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import EndStops, role
from hydroservo.core.sources import CHOSEN


@role(EndStops)
class Stops(NamedTuple):
    """A contact with a spring and a damping that grows with the penetration, at both ends.

    F = k_c d (1 + c d'), not below 0, where d is how far the piston is beyond the end

    The force starts and ends at 0, with no jump at impact. A free mass that arrives with the speed v_i
    leaves with v_o, where c v_i - ln(1 + c v_i) = -c v_o - ln(1 - c v_o): for small c v_i the restitution
    v_o/v_i is 1 - (2/3) c v_i. The defaults suit a small steel cylinder without cushions.

    Source: Hunt and Crossley, Journal of Applied Mechanics 42(2), 1975, with exponent 1 for flat faces.
    Fails where a cushion meters the oil out before contact.
    """

    stiffness: Annotated[float, Field("N/m", "contact stiffness k_c", CHOSEN, above=0)] = 1e8
    dissipation: Annotated[float, Field("s/m", "contact dissipation c", CHOSEN, at_least=0)] = 5.0

    def force(self, position: float, velocity: float, stroke: float) -> float:
        below, above = ops.maximum(-position, 0.0), ops.maximum(position - stroke, 0.0)
        outwards = below * ops.maximum(1.0 - self.dissipation * velocity, 0.0)
        inwards = above * ops.maximum(1.0 + self.dissipation * velocity, 0.0)
        return self.stiffness * (outwards - inwards)
