"""No functions: a law learns numbers alone."""

from typing import NamedTuple

from hydroservo.core.roles import Basis, role


class NoBasisState(NamedTuple):
    """Nothing is learnt."""


@role(Basis)
class NoBasis(NamedTuple):
    """In a basis's place: a(x1) = 0.

    Source: what the law is without it.
    Fails to learn what depends on the velocity otherwise than in proportion.
    """

    def init(self) -> NoBasisState:
        return NoBasisState()

    def at(self, velocity: float) -> NoBasisState:
        return NoBasisState()

    def value(self, s: NoBasisState, at: NoBasisState) -> float:
        return 0.0

    def slope(self, s: NoBasisState, at: NoBasisState) -> float:
        return 0.0

    def squared(self, at: NoBasisState) -> float:
        return 0.0

    def most(self, at: NoBasisState) -> float:
        return 0.0

    def adapted(self, s: NoBasisState, at: NoBasisState, drive: float, dt: float) -> NoBasisState:
        return s
