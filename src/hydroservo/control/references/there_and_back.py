"""A demand that goes back the way it came."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand


@role(Reference)
class ThereAndBack(NamedTuple):
    """A nested demand up to an instant T, and from there the same backwards: a working stroke and its return.

    r(t) = r_in(t) up to T, r_in(2 T - t) from then on

    Source: a definition.
    Fails to be smooth where the nested demand still moves at T, as its rate jumps to the opposite one; and
    after 2 T, where it is the nested demand before its start, which rests only for a move or a step.
    """

    reference: Reference
    turn: Annotated[float, Field("s", "instant T at which it turns", at_least=0)]

    @property
    def time(self) -> float:
        """The instant at which the nested demand begins [s]."""
        return float(getattr(self.reference, "time", 0.0))

    def at(self, t: float) -> Demand:
        back = t > self.turn
        there = self.reference.at(ops.where(back, 2.0 * self.turn - t, t))
        return Demand(there.value, ops.where(back, -there.rate, there.rate), there.second_rate)
