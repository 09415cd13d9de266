"""How a machine that meets a workpiece comes to hold a force."""

import math
from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block
from hydroservo.core.errors import ParameterError
from hydroservo.core.field import OPEN, Field
from hydroservo.core.roles import Monitor, role
from hydroservo.core.sources import CHOSEN


class ContactForceState(NamedTuple):
    """What has happened since first contact."""

    begin: float  # [s] when the demand met the workpiece; inf before contact
    pressed: float  # 1 while the force is above the threshold
    losses: float  # of contact
    largest: float  # force [N]
    outside: float  # [s] when the force was last outside the band
    held: float  # 1 while it is inside the band
    released: float  # 1 once the demand has turned back


class ContactForceValues(NamedTuple):
    """What it comes to."""

    contact_overshoot: Annotated[
        float, Field("", "furthest that the force goes beyond the held one, over it", smaller_is_better=True)
    ]
    holding_time: Annotated[
        float,
        Field(
            "s",
            "time until the force is held, from the demand's contact; inf: never",
            smaller_is_better=True,
        ),
    ]
    bounces: Annotated[float, Field("", "how often contact is lost again", smaller_is_better=True)]


@role(Monitor)
class ContactForce(NamedTuple):
    """The force at the rod from first contact until the demand turns back, against the one to be held.

    Contact begins, and ends, where the force passes a share ``band`` of the held one; held is what stays
    within that share of it. The time to hold begins where the demand meets the workpiece: a machine that lags
    behind its demand by e meets it e/r' later.

    Source: a definition.
    Fails where weight, springs or an external force alone make the rod bear more than the band.
    """

    force: Annotated[float, Field("N", "force that is to be held", "to be given", above=0, auto=OPEN)] = OPEN
    band: Annotated[
        float, Field("", "share of the force that counts as contact, and as held", CHOSEN, above=0, below=0.5)
    ] = 0.05
    allowed_overshoot: Annotated[
        float,
        Field("", "overshoot beyond which the force does not count as held", "any", at_least=0, auto=OPEN),
    ] = OPEN

    def check(self) -> None:
        if self.force == OPEN:
            raise ParameterError("force", "none", "must be the force that is to be held [N]")

    def init(self) -> ContactForceState:
        return ContactForceState(math.inf, *[0.0] * (len(ContactForceState._fields) - 1))

    def step(self, m: ContactForceState, loop: Block, s: Block, t: float, dt: float) -> ContactForceState:
        force = loop.seen(s, loop.load.force(t)).force
        band = self.band * self.force
        pressed = force > band
        first = pressed and m.begin == math.inf
        begin = ops.where(first, t - self.lag(s), m.begin)
        began = begin < math.inf
        over = m.released > 0.0 or (began and s.reference.rate < 0.0)
        lost = m.pressed > 0.0 and not pressed and not over
        inside = ops.absolute(force - self.force) <= band
        return ContactForceState(
            begin=begin,
            pressed=ops.where(pressed, 1.0, 0.0),
            losses=m.losses + ops.where(lost, 1.0, 0.0),
            largest=ops.where(over, m.largest, ops.maximum(force, m.largest)),
            outside=ops.where(began and not (over or inside), t + dt, m.outside),
            held=ops.where(over, m.held, ops.where(inside, 1.0, 0.0)),
            released=ops.where(over, 1.0, 0.0),
        )

    def lag(self, s: Block) -> float:
        """How long ago the demand was where the machine is [s]; 0 where it does not move on."""
        moves = s.reference.rate > 0.0
        rate = ops.where(moves, s.reference.rate, 1.0)
        return ops.where(moves, ops.maximum(s.reference.value - s.controlled.value, 0.0) / rate, 0.0)

    def values(self, m: ContactForceState) -> ContactForceValues:
        overshoot = max(m.largest / self.force - 1.0, 0.0)
        held = m.held > 0.0 and overshoot <= self.allowed_overshoot
        return ContactForceValues(overshoot, m.outside - m.begin if held else math.inf, m.losses)
