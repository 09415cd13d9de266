"""Compensation of a valve's overlap by a jump."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from hydroservo.control.controllers.overlaps import check_overlaps, within_overlap
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core import ops
from hydroservo.core.assumptions import Assumption, Facts
from hydroservo.core.block import Block, Field
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement


class DeadBandJumpState(NamedTuple):
    """What is put out, and what of it passes the overlap."""

    u: Annotated[float, Field("V", "command")]
    added: Annotated[float, Field("V", "what was added to the law's command")]
    controller: Block


@role(Controller)
class DeadBandJump(NamedTuple):
    """The command of a nested law, which jumps over a valve's overlap at a threshold, and is 0 within that.

    u = sat(u_law + D_extend) where u_law > threshold, sat(u_law - D_retract) where u_law < -threshold, else 0

    So the valve rests in its overlap, and leaks little, until the law asks for enough. The nested law learns
    of the applied command without what was added.

    Source: Moog ACV with CANopen bus interface, user manual B99224-DV018-D-211, Rev. A, 2018, sec. 7.2.8,
    dead band compensation of type 1 (there the largest command stays what it was).
    Fails around a law with an integrator and no dead zone: it integrates what the threshold keeps from the
    valve, jumps, and hunts; so does any law with a threshold below its noise.
    """

    controller: Controller
    extend_overlap: Annotated[float, Field("V", "command that passes it, D_extend", at_least=0)]
    retract_overlap: Annotated[float, Field("V", "command that passes it, D_retract", at_least=0)]
    threshold: Annotated[float, Field("V", "command of the law at which it jumps", at_least=0)]
    saturation: Saturation = Saturation()

    def check(self) -> None:
        check_overlaps(self.extend_overlap, self.retract_overlap, self.saturation.limit)

    def assumptions(self, facts: Facts) -> Sequence[Assumption]:
        return [within_overlap(self.extend_overlap, self.retract_overlap, facts)]

    def init(self) -> DeadBandJumpState:
        return DeadBandJumpState(0.0, 0.0, self.controller.init())

    def step(self, s: DeadBandJumpState, y: Measurement, r: Demand, dt: float) -> DeadBandJumpState:
        controller = self.controller.step(s.controller, y.with_command(y.command - s.added), r, dt)
        asked = controller.u
        retracting = ops.where(asked < -self.threshold, -self.retract_overlap, -asked)
        added = ops.where(asked > self.threshold, self.extend_overlap, retracting)
        return DeadBandJumpState(self.saturation.apply(asked + added), added, controller)
