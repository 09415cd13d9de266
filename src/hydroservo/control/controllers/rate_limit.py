"""A law whose command moves no faster than a limit."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts, above
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class RateLimitState(NamedTuple):
    """What is put out, and the nested law's state."""

    u: Annotated[float, Field("V", "command")]
    controller: Block


@role(Controller)
class RateLimit(NamedTuple):
    """The command of a nested law, with steps from sample to sample within +-rate h; from 0 at the start.

    u_k = u_(k-1) + clip(u_law - u_(k-1), -rate h, rate h)

    Source: a definition.
    Fails to leave a fast loop stable: a command that is limited in rate lags, the more the larger it is.
    """

    controller: Controller
    rate: Annotated[float, Field("V/s", "largest rate of the command", above=0)]

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        meaning = "rate is above the largest of the command"
        return [above("rate", meaning, self.rate, facts.command_rate, "V/s", measured=True)]

    def init(self) -> RateLimitState:
        return RateLimitState(0.0, self.controller.init())

    def step(self, s: RateLimitState, y: Measurement, r: Demand, dt: float) -> RateLimitState:
        controller = self.controller.step(s.controller, y, r, dt)
        most = self.rate * dt
        return RateLimitState(s.u + ops.clip(controller.u - s.u, -most, most), controller)
