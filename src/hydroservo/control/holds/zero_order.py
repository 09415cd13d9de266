"""A command held from one sample to the next."""

import math
from typing import NamedTuple

from hydroservo.core.roles import Hold, role


class ZeroOrderHoldState(NamedTuple):
    """A hold without delay remembers nothing but the command, which the controller keeps."""


@role(Hold)
class ZeroOrderHold(NamedTuple):
    """u(t) = u_k for t_k <= t < t_(k+1): the controller takes no time.

    Source: Astrom and Wittenmark, Computer-Controlled Systems, 1997, sec. 2.3.
    Fails on a real computer, whose command comes some time after its sample; see DelayedHold.
    """

    def init(self) -> ZeroOrderHoldState:
        return ZeroOrderHoldState()

    def step(self, s: ZeroOrderHoldState, u: float, t: float) -> ZeroOrderHoldState:
        return s

    def held(self, s: ZeroOrderHoldState, u: float) -> float:
        return u

    def at(self, held: float, t: float) -> float:
        return held

    def next_jump(self, held: float, t: float) -> float:
        return math.inf

    def applied(self, s: ZeroOrderHoldState, u: float, dt: float) -> float:
        return u
