"""A demand that goes from one value to another with a limited third derivative."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Field
from hydroservo.roles import Reference, role
from hydroservo.signals import Demand
from hydroservo.sources import CHOSEN

__all__ = ["PointToPoint"]

THIRD = 1.0 / 3.0


class Pieces(NamedTuple):
    """Half of a move: how far it goes, how long each of its sections takes, and all of it."""

    distance: float
    jerking: float
    steady: float
    total: float


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
        pieces = self.pieces(ops.absolute(change))
        gone = t - self.time
        left = pieces.total - gone
        first = gone < left  # half of it
        moved = self.first_half(pieces, ops.minimum(gone, left))
        way = ops.copysign(1.0, change)
        value = ops.where(first, self.initial + way * moved.value, self.final - way * moved.value)
        second = ops.where(first, way * moved.second_rate, -way * moved.second_rate)
        return Demand(value, way * moved.rate, second)

    def pieces(self, distance: float) -> Pieces:
        """How long the sections of a move are."""
        jerk = self.max_third_rate
        moves = 0.5 * distance / jerk > 0.0  # what vanishes here is no distance to go, but a jump of rounding
        h = ops.where(moves, distance, 1.0)
        shortest = ops.minimum(ops.power(0.5 * h / jerk, THIRD), ops.sqrt(self.max_rate / jerk))
        jerking = ops.minimum(shortest, self.max_second_rate / jerk)
        top = jerk * jerking  # of the second rate
        near = ops.sqrt(0.25 * jerking * jerking + h / top) - 1.5 * jerking
        steady = ops.maximum(ops.minimum(near, self.max_rate / top - jerking), 0.0)
        cruise = ops.maximum(h / (top * (jerking + steady)) - (2.0 * jerking + steady), 0.0)
        total = ops.where(moves, 2.0 * (2.0 * jerking + steady) + cruise, 0.0)
        return Pieces(distance, jerking, steady, total)

    def first_half(self, pieces: Pieces, gone: float) -> Demand:
        """How far a move has come within its first half, the sections before this instant added up."""
        jerk, jerking, steady = self.max_third_rate, pieces.jerking, pieces.steady
        rising = ops.clip(gone, 0.0, jerking)
        holding = ops.clip(gone - jerking, 0.0, steady)
        falling = ops.clip(gone - (jerking + steady), 0.0, jerking)
        cruising = ops.maximum(gone - (2.0 * jerking + steady), 0.0)
        top = jerk * jerking
        rate_1 = 0.5 * jerk * rising * rising
        rate_2 = rate_1 + top * holding
        rate_3 = rate_2 + (top - 0.5 * jerk * falling) * falling
        value = jerk * rising * rising * rising / 6.0
        value = value + (rate_1 + 0.5 * top * holding) * holding
        value = value + (rate_2 + (0.5 * top - jerk * falling / 6.0) * falling) * falling
        value = ops.minimum(value + rate_3 * cruising, 0.5 * pieces.distance)
        return Demand(value, rate_3, jerk * (rising - falling))
