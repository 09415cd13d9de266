"""A command that comes some time after its sample."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Hold, role


class DelayedHoldState(NamedTuple):
    """The command that is being replaced, and when the new one comes."""

    last: Annotated[float, Field("V", "command of the sample before")]
    switch: Annotated[float, Field("s", "instant at which the command of this sample is put out")]


class HeldTwice(NamedTuple):
    """Two commands, one after the other."""

    before: Annotated[float, Field("V", "command before the switching instant")]
    after: Annotated[float, Field("V", "command from the switching instant on")]
    switch: Annotated[float, Field("s", "switching instant")]


@role(Hold)
class DelayedHold(NamedTuple):
    """u(t) = u_(k-1) for t_k <= t < t_k + delay, and u_k from there on: the controller's computing time.

    A delay of a whole sample period means that a command is put out at the next sample; for longer ones,
    wrap the controller in Delay. A fixed-step integrator needs steps that end on the switching instants.

    Source: Astrom and Wittenmark, Computer-Controlled Systems, 1997, sec. 9.3.
    Fails where the computing time varies from sample to sample.
    """

    delay: Annotated[
        float, Field("s", "time from a sample to its command; at most a sample period", at_least=0)
    ]

    def init(self) -> DelayedHoldState:
        return DelayedHoldState(0.0, 0.0)

    def step(self, s: DelayedHoldState, u: float, t: float) -> DelayedHoldState:
        return DelayedHoldState(u, t + self.delay)

    def held(self, s: DelayedHoldState, u: float) -> HeldTwice:
        return HeldTwice(s.last, u, s.switch)

    def at(self, held: HeldTwice, t: float) -> float:
        return ops.where(ops.at_or_after(t, held.switch), held.after, held.before)

    def next_jump(self, held: HeldTwice, t: float) -> float:
        return ops.where(ops.at_or_after(t, held.switch), math.inf, held.switch)

    def applied(self, s: DelayedHoldState, u: float, dt: float) -> float:
        share = self.delay / dt
        return share * s.last + (1.0 - share) * u
