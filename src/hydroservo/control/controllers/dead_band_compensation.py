"""Compensation of a valve's overlap, continuous through zero."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.overlaps import check_overlaps, within_overlap
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class DeadBandCompensationState(NamedTuple):
    """What is put out, and what of it passes the overlap."""

    u: Annotated[float, Field("V", "command")]
    added: Annotated[float, Field("V", "command that passes the overlap")]
    controller: Block


@role(Controller)
class DeadBandCompensation(NamedTuple):
    """The command of a nested law, and what a valve needs to pass its overlap in that direction.

    u = sat(u_law + D clip(u_law/threshold, -1, 1)),  D = D_extend where u_law > 0, D_retract elsewhere

    Beyond the threshold the valve opens as one without overlap would; within it the gain is finite, 1 +
    D/threshold. The nested law learns of the applied command without what was added.

    Source: Moog ACV with CANopen bus interface, user manual B99224-DV018-D-211, Rev. A, 2018, sec. 7.2.8,
    dead band compensation of type 2 (there the largest command stays what it was).
    Fails with more than the valve's overlap, where the gain at rest is too large and the axis hunts; so it
    does with a low threshold, a slow valve or a noisy law. See DeadBandJump for one that rests.
    """

    controller: Controller
    extend_overlap: Annotated[float, Field("V", "command that passes it, D_extend", at_least=0)]
    retract_overlap: Annotated[float, Field("V", "command that passes it, D_retract", at_least=0)]
    threshold: Annotated[float, Field("V", "command of the law at which all is added", above=0)]
    saturation: Saturation = Saturation()

    def check(self) -> None:
        check_overlaps(self.extend_overlap, self.retract_overlap, self.saturation.limit)

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [within_overlap(self.extend_overlap, self.retract_overlap, facts)]

    def init(self) -> DeadBandCompensationState:
        return DeadBandCompensationState(0.0, 0.0, self.controller.init())

    def step(
        self, s: DeadBandCompensationState, y: Measurement, r: Demand, dt: float
    ) -> DeadBandCompensationState:
        controller = self.controller.step(s.controller, y.with_command(y.command - s.added), r, dt)
        overlap = ops.where(controller.u > 0.0, self.extend_overlap, self.retract_overlap)
        added = overlap * ops.clip(controller.u / self.threshold, -1.0, 1.0)
        return DeadBandCompensationState(self.saturation.apply(controller.u + added), added, controller)
