"""A law that moves, with a force that it does not exceed."""

from typing import Annotated, NamedTuple

from hydroservo.control.controllers.fixed_demand import FixedDemand
from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class ForceLimitState(NamedTuple):
    """The command, which law gave it, and the states of both laws."""

    u: Annotated[float, Field("V", "command")]
    is_limiting: Annotated[float, Field("", "1 where the law that limits gives the command, else 0")]
    controller: Block
    limiting: Block


@role(Controller)
class ForceLimit(NamedTuple):
    """A nested law that moves, and one that limits a force or a pressure: the smaller command of the two.

    u = min(u_move, u_limit)

    It presses with the limit for as long as the demand of the first law lies beyond what is pressed, and
    moves again when that demand comes back. Two continuous commands have a continuous minimum, so neither
    hand-over is a jump. Both laws are told the command that was applied: a PID with back-calculation
    (``anti_windup``) then tracks the other's command, and one with an ``integral_range`` instead keeps its
    integral while the force is far from the limit, which hands over earlier and with less overshoot.

    Source: selector (override) control: Astrom and Hagglund, Advanced PID Control, 2006.
    Fails to limit a force that pulls; and where contact is so fast or so stiff that the valve closes later
    than the force rises: the rate of the force is stiffness times speed.
    """

    controller: Controller
    limiting: FixedDemand

    def init(self) -> ForceLimitState:
        return ForceLimitState(0.0, 0.0, self.controller.init(), self.limiting.init())

    def step(self, s: ForceLimitState, y: Measurement, r: Demand, dt: float) -> ForceLimitState:
        controller = self.controller.step(s.controller, y, r, dt)
        limiting = self.limiting.step(s.limiting, y, r, dt)
        is_limiting = ops.where(limiting.u < controller.u, 1.0, 0.0)
        return ForceLimitState(ops.minimum(controller.u, limiting.u), is_limiting, controller, limiting)
