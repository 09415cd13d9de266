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
    """The demand so far, and the force since first contact."""

    furthest: float  # demand so far
    fastest: float  # rate of the demand so far
    begin: float  # [s] when the demand met the workpiece; inf before contact
    pressed: float  # 1 while the force is above the threshold
    losses: float  # of contact
    largest: float  # force [N]
    outside: float  # [s] when the force was last outside the band
    held: float  # 1 while it is inside the band
    released: float  # 1 once the demand has turned back


class ContactForceValues(NamedTuple):
    """Overshoot, time to hold and bounces; inf without contact."""

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
    within that share of it. The time to hold begins where the demand met the workpiece, the time (r - y)/r'
    before contact, r' the largest rate of the demand so far: a law gains nothing by a slow approach.

    Source: a definition.
    Fails in a loop that does not control a position, and where weight, springs or an external force alone
    make the rod bear more than the band.
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
        return ContactForceState(-math.inf, 0.0, math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, m: ContactForceState, loop: Block, s: Block, t: float, dt: float) -> ContactForceState:
        force, demand = loop.seen(s, loop.load.force(t)).force, s.reference.value
        band = self.band * self.force
        pressed, inside = force > band, ops.absolute(force - self.force) <= band
        furthest = ops.maximum(m.furthest, demand)
        fastest = ops.maximum(m.fastest, s.reference.rate)
        lag = (demand - s.controlled.value) / ops.where(fastest > 0.0, fastest, math.inf)
        met = ops.clip(t - lag, 0.0, t)
        begin = ops.where(pressed and m.begin == math.inf, met, m.begin)
        began = begin < math.inf
        over = m.released > 0.0 or (began and demand < furthest)
        lost = m.pressed > 0.0 and not pressed and not over
        return ContactForceState(
            furthest=furthest,
            fastest=fastest,
            begin=begin,
            pressed=ops.where(pressed, 1.0, 0.0),
            losses=m.losses + ops.where(lost, 1.0, 0.0),
            largest=ops.where(over, m.largest, ops.maximum(force, m.largest)),
            outside=ops.where(began and not (over or inside), t + dt, m.outside),
            held=ops.where(over, m.held, ops.where(inside, 1.0, 0.0)),
            released=ops.where(over, 1.0, 0.0),
        )

    def values(self, m: ContactForceState) -> ContactForceValues:
        if m.begin == math.inf:
            return ContactForceValues(math.inf, math.inf, math.inf)
        overshoot = max(m.largest / self.force - 1.0, 0.0)
        held = m.held > 0.0 and overshoot <= self.allowed_overshoot
        return ContactForceValues(overshoot, max(m.outside - m.begin, 0.0) if held else math.inf, m.losses)
