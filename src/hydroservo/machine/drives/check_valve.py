"""A valve that oil passes one way, or both ways while a pilot holds it open."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import CheckFlow, role
from hydroservo.core.sources import CHOSEN


@role(CheckFlow)
class CheckValve(NamedTuple):
    """Shut up to its cracking pressure p_c; wide open it passes Q = G d at a drop d.

    With the pilot's pressure p_X above that before the valve, it is open by e from 0 to 1::

        x = (d + R max(p_X, 0) - p_c)/h within 0 and 1       e = x^2 (3 - 2 x)
        Q = G e d

    so that the flow is smooth. Without a pilot (R = 0) nothing comes back; held open by one, oil passes
    backwards, too.

    Source: the balance of forces on a poppet with the areas 1 and R; the laminar flow and the transition are
    chosen here.
    Fails where the flow follows the root of the drop, and where its ball takes time to close.
    """

    cracking_pressure: Annotated[float, Field("Pa", "drop p_c at which it opens", at_least=0)]
    conductance: Annotated[float, Field("m^3/(s Pa)", "flow G per drop, wide open", above=0)]
    pilot_ratio: Annotated[float, Field("", "pilot ratio R", "0: no pilot", at_least=0)] = 0.0
    opening_range: Annotated[float, Field("Pa", "h, from cracking to wide open", CHOSEN, above=0)] = 5e4

    def flow(self, drop: float) -> float:
        """What passes without a pilot [m^3/s]."""
        return self.piloted(drop, 0.0)

    def piloted(self, drop: float, pilot: float) -> float:
        """What passes with a pilot's pressure above that before the valve [m^3/s]."""
        forced = drop + self.pilot_ratio * ops.maximum(pilot, 0.0) - self.cracking_pressure
        x = ops.clip(forced / self.opening_range, 0.0, 1.0)
        return self.conductance * (x * x * (3.0 - 2.0 * x)) * drop
