"""A relief valve's poppet that takes its time."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Poppet, role
from hydroservo.machine.supplies.relief import ReliefValve


class SlowPoppetState(NamedTuple):
    """How far it is open."""

    override: Annotated[float, Field("Pa", "opening y, as the pressure beyond cracking that would hold it")]


@role(Poppet)
class SlowPoppet(NamedTuple):
    """A poppet that follows the pressure with a first-order lag, and an orifice as open as it is.

    With the relief valve's cracking pressure p_c and gradient G, and the poppet's opening y, as the pressure
    beyond p_c that would hold it::

        T dy/dt = max(p - p_c, 0) - y
        Q       = G y sqrt(max(p, 0)/(p_c + y))

    Settled, p = p_c + y, that is the valve's own curve Q = G max(p - p_c, 0). A pressure that rises faster
    than the poppet opens shoots over, and then falls below cracking until it is shut again.

    Source: Merritt, Hydraulic Control Systems, 1967 (single-stage pressure control valves); the lag stands
    for spring, mass and damping there, and the orifice's square-root law is that of any.
    Fails where spring and mass chatter, and where a pilot stage opens at another speed than it shuts.
    """

    time_constant: Annotated[float, Field("s", "lag T of the poppet", above=0)]

    def init(self) -> SlowPoppetState:
        return SlowPoppetState(0.0)

    def steady_at(self, relief: ReliefValve, pressure: float) -> SlowPoppetState:
        return SlowPoppetState(ops.maximum(pressure - relief.cracking_pressure, 0.0))

    def deriv(self, s: SlowPoppetState, relief: ReliefValve, pressure: float) -> SlowPoppetState:
        missing = ops.maximum(pressure - relief.cracking_pressure, 0.0) - s.override
        return SlowPoppetState(missing * (1.0 / self.time_constant))

    def flow(self, s: SlowPoppetState, relief: ReliefValve, pressure: float) -> float:
        opening = ops.maximum(s.override, 0.0)
        share = ops.maximum(pressure, 0.0) / (relief.cracking_pressure + opening)
        return relief.gradient * opening * ops.sqrt(share)
