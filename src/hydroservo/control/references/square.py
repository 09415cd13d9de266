"""A square-wave demand."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.roles import Reference, role
from hydroservo.core.signals import Demand
from hydroservo.core.sources import CHOSEN


@role(Reference)
class Square(NamedTuple):
    """r = offset +- amplitude, starting with +, half a period each; both derivatives are 0.

    Source: Sec. 4 of doi:10.1007/s42401-021-00087-w.
    Fails as a demand for laws that use its derivatives: the jumps are not in them.
    """

    amplitude: Annotated[float, Field("y", "amplitude")]
    period: Annotated[float, Field("s", "period", above=0)]
    offset: Annotated[float, Field("y", "mean", CHOSEN)] = 0.0

    def at(self, t: float) -> Demand:
        return Demand(self.offset + self.amplitude * ops.square_wave(t, self.period), 0.0, 0.0)
