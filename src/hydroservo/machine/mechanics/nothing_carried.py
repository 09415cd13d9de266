"""A mechanism that carries nothing with a motion of its own."""

from typing import NamedTuple

from hydroservo.core.roles import Carried, Mechanism, role


class NothingCarriedState(NamedTuple):
    """Nothing moves by itself."""


@role(Carried)
class NothingCarried(NamedTuple):
    """The rod meets the mechanism alone.

    Source: a definition.
    Fails never.
    """

    def init(self) -> NothingCarriedState:
        return NothingCarriedState()

    def inertia(self, s: NothingCarriedState, mechanism: Mechanism, position: float) -> float:
        return mechanism.inertia(position)

    def resistance(
        self, s: NothingCarriedState, mechanism: Mechanism, position: float, velocity: float
    ) -> float:
        return mechanism.resistance(position, velocity)

    def deriv(
        self,
        s: NothingCarriedState,
        mechanism: Mechanism,
        position: float,
        velocity: float,
        acceleration: float,
    ) -> NothingCarriedState:
        return s
