"""A servo valve whose spool follows at once."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import MeteringEdges, Valve, role
from hydroservo.machine.valves.orifice import check_opens


class StaticValveState(NamedTuple):
    """A static valve remembers nothing."""


@role(Valve)
class StaticValve(NamedTuple):
    """x_v = K_sv u within +-x_max, with no lag.

    Source: eq. (1) of doi:10.1007/s42401-021-00087-w.
    Fails above a tenth of a real valve's bandwidth; see FirstOrderValve.
    """

    gain: Annotated[float, Field("m/V", "servo valve gain K_sv", above=0)]
    max_opening: Annotated[float, Field("m", "spool limit x_max", above=0)]
    orifice: MeteringEdges

    def check(self) -> None:
        check_opens(self.orifice, self.max_opening)

    def init(self) -> StaticValveState:
        return StaticValveState()

    def deriv(self, s: StaticValveState, u: float) -> StaticValveState:
        return s

    def opening(self, s: StaticValveState, u: float) -> float:
        return ops.clip(self.gain * u, -self.max_opening, self.max_opening)
