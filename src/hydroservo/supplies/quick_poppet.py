"""A relief valve's poppet that follows at once."""

from typing import NamedTuple

from hydroservo.roles import Poppet, role
from hydroservo.supplies.relief import ReliefValve

__all__ = ["QuickPoppet", "QuickPoppetState"]


class QuickPoppetState(NamedTuple):
    """It remembers nothing."""


@role(Poppet)
class QuickPoppet(NamedTuple):
    """The flow is that of the relief valve's curve, at once.

    Source: a definition.
    Fails where the pressure rises faster than a poppet moves; see SlowPoppet.
    """

    def init(self) -> QuickPoppetState:
        return QuickPoppetState()

    def settled(self, relief: ReliefValve, pressure: float) -> QuickPoppetState:
        return QuickPoppetState()

    def deriv(self, s: QuickPoppetState, relief: ReliefValve, pressure: float) -> QuickPoppetState:
        return s

    def flow(self, s: QuickPoppetState, relief: ReliefValve, pressure: float) -> float:
        return relief.flow(pressure)
