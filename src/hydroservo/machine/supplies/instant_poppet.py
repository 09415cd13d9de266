"""A relief valve's poppet that follows at once."""

from typing import NamedTuple

from hydroservo.core.roles import Poppet, role
from hydroservo.machine.supplies.relief import ReliefValve


class InstantPoppetState(NamedTuple):
    """It remembers nothing."""


@role(Poppet)
class InstantPoppet(NamedTuple):
    """The flow is that of the relief valve's curve, at once.

    Source: a definition.
    Fails where the pressure rises faster than a poppet moves; see SlowPoppet.
    """

    def init(self) -> InstantPoppetState:
        return InstantPoppetState()

    def steady_at(self, relief: ReliefValve, pressure: float) -> InstantPoppetState:
        return InstantPoppetState()

    def deriv(self, s: InstantPoppetState, relief: ReliefValve, pressure: float) -> InstantPoppetState:
        return s

    def flow(self, s: InstantPoppetState, relief: ReliefValve, pressure: float) -> float:
        return relief.flow(pressure)
