"""A demand that goes from one value to another with a limited third derivative."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN

THIRD = 1.0 / 3.0


class Sections(NamedTuple):
    """How far a move goes, and how long it and the sections of its first half are."""

    distance: float
    rise_time: float  # of the second rate to its top; it falls in the same time
    top_time: float  # for which the second rate stays there
    total: float


class Limits(NamedTuple):
    """The largest rates of a move, and what they make of it."""

    rate: float
    second_rate: float
    third_rate: float

    def sections(self, distance: float) -> Sections:
        """How long the sections of a move are."""
        third_rate = self.third_rate
        # h/(2 J) underflows to 0 for the smallest changes; these are done at once.
        moves = 0.5 * distance / third_rate > 0.0
        h = ops.where(moves, distance, 1.0)
        shortest = ops.minimum(ops.power(0.5 * h / third_rate, THIRD), ops.sqrt(self.rate / third_rate))
        rise_time = ops.minimum(shortest, self.second_rate / third_rate)
        top = third_rate * rise_time  # of the second rate
        near = ops.sqrt(0.25 * rise_time * rise_time + h / top) - 1.5 * rise_time
        top_time = ops.maximum(ops.minimum(near, self.rate / top - rise_time), 0.0)
        cruise = ops.maximum(h / (top * (rise_time + top_time)) - (2.0 * rise_time + top_time), 0.0)
        total = ops.where(moves, 2.0 * (2.0 * rise_time + top_time) + cruise, 0.0)
        return Sections(distance, rise_time, top_time, total)

    def first_half(self, sections: Sections, gone: float) -> Demand:
        """How far a move has come within its first half, the sections before this instant added up."""
        third_rate, rise_time, top_time = self.third_rate, sections.rise_time, sections.top_time
        rising = ops.clip(gone, 0.0, rise_time)
        holding = ops.clip(gone - rise_time, 0.0, top_time)
        falling = ops.clip(gone - (rise_time + top_time), 0.0, rise_time)
        cruising = ops.maximum(gone - (2.0 * rise_time + top_time), 0.0)
        top = third_rate * rise_time
        rate_1 = 0.5 * third_rate * rising * rising
        rate_2 = rate_1 + top * holding
        rate_3 = rate_2 + (top - 0.5 * third_rate * falling) * falling
        value = third_rate * rising * rising * rising / 6.0
        value = value + (rate_1 + 0.5 * top * holding) * holding
        value = value + (rate_2 + (0.5 * top - third_rate * falling / 6.0) * falling) * falling
        value = ops.minimum(value + rate_3 * cruising, 0.5 * sections.distance)
        return Demand(value, rate_3, third_rate * (rising - falling))


@role(Reference)
class PointToPoint(NamedTuple):
    """From initial to final as fast as three limits allow, starting and ending at rest: a double S.

    Over h = abs(final - initial), with the limits V of the rate, A of the second and J of the third::

        T_j = min((h/(2 J))^(1/3), sqrt(V/J), A/J)            each of the four sections with third rate +-J
        T_a = min(sqrt(T_j^2/4 + h/(J T_j)) - 3/2 T_j, V/(J T_j) - T_j)    the two of constant second rate
        T_v = h/(J T_j (T_j + T_a)) - (2 T_j + T_a)                        that of constant rate

    A limit that is not reached makes the sections that would hold it vanish. For a position the limits are
    those of velocity, acceleration and jerk. The second half mirrors the first, so that final is met exactly.

    Source: Biagiotti, Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, sec. 3.4.
    Fails as a demand for what needs a continuous third rate: that jumps between sections.
    """

    initial: Annotated[float, Field("y", "demand before the move")]
    final: Annotated[float, Field("y", "demand after the move")]
    max_rate: Annotated[float, Field("y/s", "largest rate", above=0)]
    max_second_rate: Annotated[float, Field("y/s^2", "largest second rate", above=0)]
    max_third_rate: Annotated[float, Field("y/s^3", "largest third rate", above=0)]
    time: Annotated[float, Field("s", "start of the move", CHOSEN, at_least=0)] = 0.1

    def at(self, t: float) -> Demand:
        change = self.final - self.initial
        limits = Limits(self.max_rate, self.max_second_rate, self.max_third_rate)
        sections = limits.sections(ops.absolute(change))
        gone = t - self.time
        left = sections.total - gone
        first = gone < left  # half of it
        half = limits.first_half(sections, ops.minimum(gone, left))
        way = ops.copysign(1.0, change)
        value = ops.where(first, self.initial + way * half.value, self.final - way * half.value)
        second = ops.where(first, way * half.second_rate, -way * half.second_rate)
        return Demand(value, way * half.rate, second)
