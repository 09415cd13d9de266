"""Velocity feedforward around a law that controls a force or a pressure."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.assumptions import Assumption, Facts, below
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class VelocityCompensationState(NamedTuple):
    """What is put out, and what the motion takes of it."""

    u: Annotated[float, Field("V", "command")]
    for_motion: Annotated[float, Field("V", "command for the flow that the motion takes")]
    controller: Block


@role(Controller)
class VelocityCompensation(NamedTuple):
    """The command of a nested law, and that for the flow which the measured motion takes.

    u = sat(u_law + k_v v)

    A cylinder that is moved from outside changes its force by what oil it takes in; with k_v = 1/K_v, K_v
    [m/(s V)] its velocity per command, the valve lets in just that oil, and the law, of force or of pressure,
    acts on a cylinder that seems to stand still. The nested law learns of the applied command without it.

    Source: Alleyne and Liu, A simplified approach to force control for electro-hydraulic systems, Control
    Engineering Practice 8, 2000, pp. 1347-1356 (a velocity term and the force error).
    Fails beyond k_v = 1/K_v, where the positive feedback drives the axis away, and by what the valve is
    late: a slow one compensates slow motion only.
    """

    controller: Controller
    velocity_gain: Annotated[float, Field("V s/m", "command per velocity k_v", at_least=0)]
    saturation: Saturation = Saturation()

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        truth = facts.truth
        if truth is None:
            return []
        gain = -truth.f2(1.0, 0.0) / truth.g2(0.0, 0.0)
        meaning = "k_v is at most the command per velocity"
        return [below("feedback", meaning, self.velocity_gain, 1.0001 * gain, "V s/m")]

    def init(self) -> VelocityCompensationState:
        return VelocityCompensationState(0.0, 0.0, self.controller.init())

    def step(
        self, s: VelocityCompensationState, y: Measurement, r: Demand, dt: float
    ) -> VelocityCompensationState:
        for_motion = self.velocity_gain * y.velocity
        controller = self.controller.step(s.controller, y.with_command(y.command - s.for_motion), r, dt)
        return VelocityCompensationState(
            self.saturation.apply(controller.u + for_motion), for_motion, controller
        )
