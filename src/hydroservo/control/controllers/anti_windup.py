"""Anti-windup around any law."""

from typing import Annotated, NamedTuple

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class AntiWindupState(NamedTuple):
    """What is put out, the nested law's state after and before its last sample, and what that was given."""

    u: Annotated[float, Field("V", "command")]
    controller: Block
    before: Block
    y: Measurement
    r: Demand


@role(Controller)
class AntiWindup(NamedTuple):
    """A nested law that remembers only demands which could be met: Hanus' conditioning.

    If what was applied since the last sample is not what the law asked for, its last step is done again with
    the demand under which it would have asked for just that, the realisable reference::

        r' = r + (u_applied - u_law)/gain

    and the law goes on from there. The gain is du/dr of the law within one sample: the proportional gain of a
    PI, which then is PI's back-calculation with k_aw = k_i/gain. Any limit further out counts (DAC,
    RateLimit, the saturation here), for u_applied is the measurement's command; as long as nothing limits,
    the law runs as if it were alone. Of the demand only the value is corrected, not its rates.

    The law inside must be free to ask for more than can be applied, so its own saturation, if it has one,
    must be wider than the limits outside.

    Source: Hanus, Kinnaert, Henrotte, Automatica 23(6), 1987.
    Fails for a law without a direct gain from the demand's value to u, and where the sign or size of that
    gain changes much, and inside a ValveInversion, which tells its law of openings and not of commands: it
    belongs around that. What a delay leaves of the last command in u_applied counts as a limit too. It takes
    the law's time twice.
    """

    controller: Controller
    gain: Annotated[float, Field("V/y", "du/dr of the law within a sample", above=0)]
    saturation: Saturation = Saturation()

    def check(self) -> None:
        inside = getattr(self.controller, "saturation", None)
        if inside is not None and not inside.limit > self.saturation.limit:
            allowed = (
                f"must be above saturation.limit, {self.saturation.limit:g} [V]: "
                "the law inside must be free to ask for more"
            )
            raise ParameterError("controller.saturation.limit", inside.limit, allowed)

    def init(self) -> AntiWindupState:
        first = self.controller.init()
        rest, still = Measurement(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Demand(0.0, 0.0, 0.0)
        return AntiWindupState(0.0, first, first, rest, still)

    def step(self, s: AntiWindupState, y: Measurement, r: Demand, dt: float) -> AntiWindupState:
        excess = y.command - s.controller.u
        realisable = Demand(s.r.value + excess * (1.0 / self.gain), s.r.rate, s.r.second_rate)
        again = self.controller.step(s.before, s.y, realisable, dt)
        before = ops.where(excess == 0.0, s.controller, again)
        controller = self.controller.step(before, y, r, dt)
        return AntiWindupState(self.saturation.apply(controller.u), controller, before, y, r)
